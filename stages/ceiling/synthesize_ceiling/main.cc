// SPDX-License-Identifier: Apache-2.0
// synthesize_ceiling: makes up the recording of a robot whose camera looks straight up. Writes the
// summary `site` and, next to it, rgb/, rgb.txt, odometry.csv, robot_groundtruth.txt,
// camera_groundtruth.txt and truth/ceiling.json.
#include "pipeline/base/files.h"
#include "pipeline/program/stage_main.h"
#include "stages/ceiling/synthesize_ceiling/synthesize_ceiling.h"
#include "stages/ceiling/synthesize_ceiling/write_ceiling.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "synthesize_ceiling",
      "makes up pictures of ceilings and wheel odometry of a robot, with exact ground truth",
      {},
      {{"site", "summary of the recording; pictures, lists and truth are written next to it"}}};
  return StageMain(argc,
                   argv,
                   spec,
                   SynthesizeCeilingOptions{},
                   [](const SynthesizeCeilingOptions& options, StageContext& context) {
                     context.BeginPart("plan");
                     const CeilingRecording recording =
                         PlanCeilingRecording(options, context.NumThreads());
                     for (const auto& [name, bytes] : CeilingListsAndTruth(recording)) {
                       WriteFile(context.OutputBeside("site", name), bytes);
                     }

                     context.BeginPart("render");
                     ClearCeilingRecording(context.FinalPath("site"));
                     RenderCeilingInto(context.FinalPath("site").parent_path(),
                                       options,
                                       recording,
                                       context.GetProgress(),
                                       context.NumThreads());
                     context.Report() = DescribeCeilingRecording(recording);
                     WriteFile(context.Output("site"), context.Report().dump(2) + "\n");
                   });
}
