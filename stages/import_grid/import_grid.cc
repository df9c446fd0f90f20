// SPDX-License-Identifier: Apache-2.0
#include "stages/import_grid/import_grid.h"

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/io/floors_io.h"
#include "pipeline/io/grid_io.h"

namespace nightmap {

void ImportGrid(const ImportGridOptions&, StageContext& context) {
  const auto& yaml = context.Input("map");
  const OccupancyGrid grid = ReadGrid(yaml);
  context.AddInput(GridImagePath(yaml), yaml);
  const auto count = [&](CellValue value) { return std::ranges::count(grid.cells, value); };
  if (count(kFreeCell) == 0) {
    throw DataError("{}: no cell is free; check free_thresh and negate", yaml.string());
  }
  const auto name = [&](const char* port) { return context.FinalPath(port).filename().string(); };
  FloorFiles floor;
  floor.yaml = name("yaml");
  floor.png = name("png");
  WriteFile(context.Output("pgm"), GridToPgm(grid));
  WriteFile(context.Output("yaml"), GridToYaml(grid, name("pgm")));
  WritePng(context.Output("png"), GridToImage(grid));
  WriteFile(context.Output("floors"), FloorsToJson({floor}));
  context.Report() = {{"num_free_cells", count(kFreeCell)},
                      {"num_occupied_cells", count(kOccupiedCell)},
                      {"resolution_m", grid.resolution_m}};
}

}  // namespace nightmap
