// SPDX-License-Identifier: Apache-2.0
// grid: projects the octree's obstacle band to a 2-D occupancy grid. Reads map.ot; writes map.pgm
// and map.yaml, the pair ROS map_server reads.
#include "pipeline/base/files.h"
#include "pipeline/base/stage_main.h"
#include "pipeline/io/grid_io.h"
#include "pipeline/io/octree_io.h"
#include "stages/grid/grid.h"

namespace {

void Report(const nightmap::GridResult& result, nlohmann::json& report) {
  const nightmap::OccupancyGrid& grid = result.grid;
  const double cell_m2 = grid.resolution_m * grid.resolution_m;
  report["width_cells"] = grid.width;
  report["height_cells"] = grid.height;
  report["resolution_m"] = grid.resolution_m;
  report["num_free_cells"] = result.num_free_cells;
  report["num_occupied_cells"] = result.num_occupied_cells;
  report["num_unknown_cells"] = result.num_unknown_cells;
  report["num_floor_cells"] = result.num_floor_cells;
  report["num_removed_specks"] = result.num_removed_specks;
  report["free_area_m2"] = cell_m2 * static_cast<double>(result.num_free_cells);
  report["seen_area_m2"] =
      cell_m2 * static_cast<double>(result.num_free_cells + result.num_occupied_cells);
}

}  // namespace

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{"grid",
                       "projects the octree's obstacle band to a 2-D occupancy grid",
                       {{"octree", "map.ot of the octree stage"}},
                       {{"pgm", "grid image: 254 free, 0 occupied, 205 unknown"},
                        {"yaml", "map_server's description of the image"}}};
  return StageMain(
      argc, argv, spec, GridOptions{}, [](const GridOptions& options, StageContext& context) {
        context.BeginPart("read");
        const OccupancyTree tree = ReadOctree(context.Input("octree"));
        context.BeginPart("project");
        const GridResult result = RunGrid(options, tree, context.GetProgress());
        context.BeginPart("write");
        const auto image =
            context.FinalPath("pgm").lexically_proximate(context.FinalPath("yaml").parent_path());
        WriteFile(context.Output("pgm"), GridToPgm(result.grid));
        WriteFile(context.Output("yaml"), GridToYaml(result.grid, image.generic_string()));
        Report(result, context.Report());
      });
}
