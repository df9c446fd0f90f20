// SPDX-License-Identifier: Apache-2.0
// plan: finds and draws a path on a floor's grid between points, queries, objects and things.
#include "pipeline/program/stage_main.h"
#include "stages/plan/plan/no_path.h"
#include "stages/plan/plan/path_output.h"
#include "stages/plan/plan/plan.h"
#include "stages/plan/plan/read_inputs.h"

namespace {
using namespace nightmap;

PlanResult PlanOrDraw(const PlanOptions& options, const PlanInputs& inputs, StageContext& context) {
  try {
    return RunPlan(options, inputs, context.GetProgress(), context.NumThreads());
  } catch (const DataError&) {
    context.LeaveFailureFile([&](const std::filesystem::path& path) {
      WritePng(path, DrawNoPath(options, inputs, context.NumThreads()));
    });
    throw;
  }
}

void Run(const PlanOptions& options, StageContext& context) {
  context.BeginPart("read");
  const PlanInputs inputs = ReadPlanInputs(options, context);
  context.BeginPart("plan");
  const auto result = PlanOrDraw(options, inputs, context);
  LogPlan(options, result);
  context.BeginPart("write");
  WriteFile(context.Output("csv"), PathToCsv(result));
  WriteFile(context.Output("json"), PathToJson(result, context.ConfigToml()).dump(2) + "\n");
  context.WriteIfWanted("nav", [&] { return PathToNavYaml(result); });
  if (context.HasOutput("png")) WritePng(context.Output("png"), DrawPath(options, inputs, result));
  context.Report().update(PathFigures(result));
}

}  // namespace

int main(int argc, char** argv) {
  const StageSpec spec{
      "plan",
      "finds a path on the grid between points, located queries, objects or things",
      {{"grid", "floors.json of the grid stage, or an imported map.yaml"},
       {"queries", "queries.csv of the job localize", Arity::kOptional},
       {"objects",
        "objects.yaml, which may name the ends",
        Arity::kOptional,
        PortKind::kFile,
        [](const std::filesystem::path& file, const PortPaths&) { ReadObjects(file); }},
       {"things", "things.json, which may name them and their classes too", Arity::kOptional},
       {"trajectory", "trajectory to draw on path.png", Arity::kOptional}},
      {{"csv", "path: x_m,y_m,heading_rad,distance_m,leg_idx,clearance_m,z_m,floor"},
       {"json", "ends, legs and figures of the path"},
       {"nav", "path as ROS's nav_msgs/Path, YAML", Arity::kOptional},
       {"png", "picture of the path on the grid", Arity::kOptional}},
      "no_path.png"};
  return StageMain(argc, argv, spec, PlanOptions{}, Run);
}
