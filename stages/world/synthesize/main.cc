// SPDX-License-Identifier: Apache-2.0
// synthesize: renders an RGB-D recording of a synthetic building in the TUM layout. Writes the
// summary `site` and, next to it, rgb/ depth/ labels/, their lists, groundtruth.txt, queries/,
// truth/; of an upward camera up/; of a robot with a laser robot.log and robot_groundtruth.txt.
#include "pipeline/program/stage_main.h"
#include "stages/world/synthesize/robot_recording.h"
#include "stages/world/synthesize/synthesize.h"
#include "stages/world/synthesize/write_site.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "synthesize",
      "renders an RGB-D recording of a synthetic building with exact ground truth",
      {},
      {{"site", "summary of the recording; pictures, lists and truth are written next to it"}}};
  return StageMain(
      argc,
      argv,
      spec,
      SynthesizeOptions{},
      [](const SynthesizeOptions& options, StageContext& context) {
        context.BeginPart("plan");
        const SynthesizePlan plan = PlanSynthesize(options, context.NumThreads());
        auto files = ListsAndTruth(options, plan);
        nlohmann::json report = DescribePlan(options, plan);
        if (options.scanner.rate_hz > 0) {
          context.BeginPart("scan");
          const RobotRecording robot = RecordRobot(options, plan, context.NumThreads());
          files.push_back({kRobotLog, CarmenLog(robot)});
          files.push_back({kRobotTruth, RobotTruth(robot)});
          report.update(DescribeRobot(robot));
        }
        for (const auto& [name, bytes] : files) {
          WriteFile(context.OutputBeside("site", name), bytes);
        }

        context.BeginPart("render");
        const auto folder = context.FinalPath("site").parent_path();
        ClearRecording(context.FinalPath("site"), options);
        RenderInto(folder, options, plan, context.GetProgress(), context.NumThreads());
        if (!plan.upward.empty()) {
          context.BeginPart("render_upward");
          RenderUpwardInto(folder, options, plan, context.GetProgress(), context.NumThreads());
        }
        context.Report() = report;
        WriteFile(context.Output("site"), report.dump(2) + "\n");
      });
}
