// SPDX-License-Identifier: Apache-2.0
// objects: proposes object features, places of the map that a scan is recognized by. Reads
// floors.json and the grid of the floor at z = 0; writes objects.yaml and a picture of them.
#include "stages/laser/objects/objects.h"

#include <spdlog/spdlog.h>

#include "pipeline/plan/floors_io.h"
#include "pipeline/program/stage_main.h"

namespace {

using namespace nightmap;

void Run(const ObjectsOptions& options, StageContext& context) {
  context.BeginPart("read");
  const auto floors = ReadFloors(context.Input("grid"));
  const OccupancyGrid grid = ReadFloorGrid(context, "grid", floors[FindFloor(floors, 0).value()]);
  context.BeginPart("propose");
  const auto result = RunObjects(options, grid, context.GetProgress(), context.NumThreads());
  for (const std::string& notice : result.notices) spdlog::info("{}", notice);
  if (result.objects.empty()) {
    spdlog::warn(
        "no place of the map looks like no other: {} places have corners, and none has a "
        "distinctiveness of objects.min_distinctiveness, {}; draw objects by hand, or lower it",
        result.num_places,
        options.min_distinctiveness);
  }
  context.BeginPart("write");
  WriteFile(context.Output("objects"), ObjectsToYaml(result.objects));
  if (context.HasOutput("png")) {
    WritePng(context.Output("png"), DrawObjects(grid, result.objects));
  }
  context.Report() = DescribeObjects(result);
}

}  // namespace

int main(int argc, char** argv) {
  const StageSpec spec{"objects",
                       "proposes objects: places of the map that a scan is recognized by",
                       {{"grid", "floors.json of the grid stage, or an imported map.yaml"}},
                       {{"objects", "objects.yaml: rectangles on the map, most distinctive first"},
                        {"png", "picture of the rectangles on the grid", Arity::kOptional}}};
  return StageMain(argc, argv, spec, ObjectsOptions{}, Run);
}
