// SPDX-License-Identifier: Apache-2.0
// synthesize: renders an RGB-D recording of a synthetic building in the TUM layout. Writes the
// summary `site` and, next to it, rgb/ depth/ labels/, their lists, groundtruth.txt, queries/,
// truth/.
#include "pipeline/io/grid_io.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/program/stage_main.h"
#include "stages/synthesize/synthesize.h"
#include "stages/synthesize/write_site.h"

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
        const auto write = [&context](const std::string& name, const std::string& bytes) {
          WriteFile(context.OutputBeside("site", name), bytes);
        };
        const std::string truth_comment = "building_from_camera; time_s tx ty tz qx qy qz qw";
        write("rgb.txt", FileList(plan.frames, "rgb", "jpg"));
        write("depth.txt", FileList(plan.frames, "depth", "png"));
        write("groundtruth.txt", TrajectoryToTum(plan.frames, truth_comment));
        write("camera.json", CameraJson(options));
        write("queries/rgb.txt", FileList(plan.queries, "rgb", "jpg"));
        write("queries/depth.txt", FileList(plan.queries, "depth", "png"));
        write("queries/groundtruth.txt", TrajectoryToTum(plan.queries, truth_comment));
        for (std::size_t i = 0; i < plan.floor_plans.size(); ++i) {
          const std::string name = FloorPlanName(i);
          write("truth/" + name + ".pgm", GridToPgm(plan.floor_plans[i]));
          write("truth/" + name + ".yaml", GridToYaml(plan.floor_plans[i], name + ".pgm"));
        }
        write("truth/boxes.json", TruthJson(plan.world));
        write("truth/surfaces.ply", TruthMesh(plan.world));

        context.BeginPart("render");
        const auto folder = context.FinalPath("site").parent_path();
        ClearRecording(context.FinalPath("site"));
        const std::filesystem::path queries = folder / "queries";
        const WritingFolder writing(folder), writing_queries(queries);
        const auto sink = [&](bool is_query, std::size_t idx, const RenderedFrame& frame) {
          WriteFrame(is_query ? queries : folder, is_query ? writing_queries : writing, idx, frame);
        };
        RunSynthesize(options, plan, sink, context.GetProgress(), context.NumThreads());
        context.Report() = DescribePlan(options, plan);
        WriteFile(context.Output("site"), context.Report().dump(2) + "\n");
      });
}
