// SPDX-License-Identifier: Apache-2.0
// plan: finds a path on the grid from one point or picture to another. Reads map.yaml with map.pgm
// and, where given, queries.csv and trajectory.tum; writes path.csv, path.json and path.png.
#include <spdlog/spdlog.h>

#include "pipeline/base/files.h"
#include "pipeline/base/stage_main.h"
#include "pipeline/io/trajectory_io.h"
#include "stages/plan/path_output.h"
#include "stages/plan/plan.h"

namespace {

using namespace nightmap;

PlanInputs ReadInputs(const StageContext& context) {
  const auto& yaml = context.Input("yaml");
  if (!std::filesystem::equivalent(GridImagePath(yaml), context.Input("pgm"))) {
    throw UsageError(
        "--in pgm={} is not the image {} names", context.Input("pgm").string(), yaml.string());
  }
  PlanInputs inputs{ReadGrid(yaml), {}, {}};
  if (context.HasInput("queries")) inputs.queries = ReadQueries(context.Input("queries"));
  if (context.HasInput("trajectory")) inputs.trajectory = ReadTum(context.Input("trajectory"));
  return inputs;
}

void Run(const PlanOptions& options, StageContext& context) {
  context.BeginPart("read");
  const PlanInputs inputs = ReadInputs(context);
  context.BeginPart("plan");
  const auto result = RunPlan(options, inputs, context.GetProgress(), context.NumThreads());
  for (const Endpoint* end : {&result.start, &result.goal}) {
    spdlog::info(
        "{} is '{}', moved by {:.3f} m", end->request.role, end->request.text, end->moved_by_m);
  }
  context.BeginPart("write");
  const auto json = PathToJson(result, context.ConfigToml());
  WriteFile(context.Output("csv"), PathToCsv(result));
  WriteFile(context.Output("json"), json.dump(2) + "\n");
  WritePng(context.Output("png"), DrawPath(inputs, result, options.robot.robot_radius_m));
  context.Report().update(PathFigures(result));
}

}  // namespace

int main(int argc, char** argv) {
  const StageSpec spec{"plan",
                       "finds a path on the grid between two points or pictures",
                       {{"yaml", "map.yaml of the grid stage, or an imported map_server map"},
                        {"pgm", "the image that the yaml names"},
                        {"queries", "queries.csv of the localize stage", Arity::kOptional},
                        {"trajectory", "drawn on path.png", Arity::kOptional}},
                       {{"csv", "path: x_m,y_m,heading_rad,distance_m"},
                        {"json", "both ends and the path's figures"},
                        {"png", "picture of the path on the grid"}}};
  return StageMain(argc, argv, spec, PlanOptions{}, Run);
}
