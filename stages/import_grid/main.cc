// SPDX-License-Identifier: Apache-2.0
// import_grid: reads the YAML and PGM of a ROS map that another system made; writes them as the
// grid stage writes its own, one floor at z = 0. The map's frame must be that of the site's map.
#include <algorithm>

#include "pipeline/base/stage_main.h"
#include "pipeline/io/floors_io.h"
#include "pipeline/io/grid_io.h"

namespace {

using namespace nightmap;

struct ImportGridOptions {
  void Register(OptionList&) {}
};

void Run(const ImportGridOptions&, StageContext& context) {
  const auto& yaml = context.Input("map");
  const OccupancyGrid grid = ReadGrid(yaml);
  context.AddInput(GridImagePath(yaml), yaml);
  const auto count = [&](CellValue value) { return std::ranges::count(grid.cells, value); };
  if (count(kFreeCell) == 0) {
    throw DataError("{}: no cell is free; check free_thresh and negate", yaml.string());
  }
  const auto name = [&](const char* port) { return context.FinalPath(port).filename().string(); };
  WriteFile(context.Output("pgm"), GridToPgm(grid));
  WriteFile(context.Output("yaml"), GridToYaml(grid, name("pgm")));
  WritePng(context.Output("png"), GridToImage(grid));
  WriteFile(context.Output("floors"), FloorsToJson({{.yaml = name("yaml"), .png = name("png")}}));
  context.Report() = {{"num_free_cells", count(kFreeCell)},
                      {"num_occupied_cells", count(kOccupiedCell)},
                      {"resolution_m", grid.resolution_m}};
}

}  // namespace

int main(int argc, char** argv) {
  const StageSpec spec{"import_grid",
                       "takes a ROS map of another system as the grid of the site",
                       {{"map", "YAML of map_server; its PGM is found beside it"}},
                       {{"floors", "floors.json: one floor at z = 0"},
                        {"pgm", "the grid: 254 free, 0 occupied, 205 unknown"},
                        {"yaml", "map_server's description of that image"},
                        {"png", "the same image for people"}}};
  return StageMain(argc, argv, spec, ImportGridOptions{}, Run);
}
