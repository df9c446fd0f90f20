// SPDX-License-Identifier: Apache-2.0
// import_grid: reads the YAML of a ROS map and the picture that it names, which becomes an input
// too; writes them as the grid stage writes its own, as one floor at z = 0.
#include "stages/plan/import_grid/import_grid.h"

#include "pipeline/io/trajectory_io.h"
#include "pipeline/plan/floors_io.h"
#include "pipeline/program/stage_main.h"

namespace nightmap {
namespace {

void Run(const ImportGridOptions&, StageContext& context) {
  const auto& yaml = context.Input("map");
  const OccupancyGrid grid = ReadGrid(yaml);
  context.AddInput(GridImagePath(yaml), yaml);
  const auto trajectory = context.HasInput("trajectory") ? ReadTum(context.Input("trajectory"))
                                                         : std::vector<StampedPose>();
  context.Report() = RunImportGrid(grid);
  CheckPlace(grid, trajectory, yaml.string());
  WriteOneFloor(grid, context);
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{"import_grid",
                       "imports a ROS map of another system as the grid of the site",
                       {CheckedPort("map",
                                    "YAML of map_server, which names its picture",
                                    [](const std::filesystem::path& yaml) { ReadGrid(yaml); }),
                        {"trajectory",
                         "trajectory.tum of the map_frame stage, which must be in the map",
                         Arity::kOptional}},
                       {{"floors", "floors.json: one floor at z = 0"},
                        {"pgm", "grid: 254 free, 0 occupied, 205 unknown"},
                        {"yaml", "map_server's description of that image"},
                        {"png", "the grid as a picture"}}};
  return StageMain(argc, argv, spec, ImportGridOptions{}, Run);
}
