// SPDX-License-Identifier: Apache-2.0
// plan: finds and draws a path on a floor's grid between points, queries, objects and things.
#include <spdlog/spdlog.h>

#include "pipeline/io/things_io.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/program/stage_main.h"
#include "stages/plan/path_output.h"
#include "stages/plan/plan.h"

namespace {
using namespace nightmap;

PlanInputs ReadInputs(const PlanOptions& options, StageContext& context) {
  PlanInputs inputs;
  inputs.floors = ReadFloors(context.Input("grid"));
  if (context.HasInput("queries")) inputs.queries = ReadQueries(context.Input("queries"));
  if (context.HasInput("trajectory")) inputs.trajectory = ReadTum(context.Input("trajectory"));
  if (context.HasInput("objects")) inputs.objects = ReadObjects(context.Input("objects"));
  if (context.HasInput("things")) inputs.things = ReadThings(context.Input("things"));
  inputs.floor_idx = PlanFloor(options, inputs);
  inputs.grid = ReadFloorGrid(context, "grid", inputs.floors[inputs.floor_idx]);
  return inputs;
}

void Run(const PlanOptions& options, StageContext& context) {
  context.BeginPart("read");
  const PlanInputs inputs = ReadInputs(options, context);
  context.BeginPart("plan");
  const auto result = RunPlan(options, inputs, context.GetProgress(), context.NumThreads());
  spdlog::info("on {}, {}", FloorText(result.floor), result.floor.yaml);
  for (const Endpoint& end : result.ends)
    spdlog::info("{} moved by {:.3f} m", EndText(end.request), end.moved_by_m);
  context.BeginPart("write");
  WriteFile(context.Output("csv"), PathToCsv(result));
  WriteFile(context.Output("json"), PathToJson(result, context.ConfigToml()).dump(2) + "\n");
  context.WriteIfWanted("nav", [&] { return PathToNavYaml(result); });
  if (context.HasOutput("png"))
    WritePng(context.Output("png"), DrawPath(inputs, result, options.footprint));
  context.Report().update(PathFigures(result));
}

}  // namespace

int main(int argc, char** argv) {
  const StageSpec spec{
      "plan",
      "finds a path on the grid between points, located queries, objects or things",
      {{"grid", "floors.json of the grid stage, or an imported map.yaml"},
       {"queries", "queries.csv of the job localize", Arity::kOptional},
       {"objects", "objects.yaml, which may name the ends", Arity::kOptional},
       {"things", "objects.json, which may name them and their classes too", Arity::kOptional},
       {"trajectory", "trajectory to draw on path.png", Arity::kOptional}},
      {{"csv", "path: x_m,y_m,heading_rad,distance_m,leg_idx,clearance_m,z_m,floor"},
       {"json", "ends, legs and figures of the path"},
       {"nav", "path as ROS's nav_msgs/Path, YAML", Arity::kOptional},
       {"png", "picture of the path on the grid", Arity::kOptional}}};
  return StageMain(argc, argv, spec, PlanOptions{}, Run);
}
