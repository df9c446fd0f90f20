// SPDX-License-Identifier: Apache-2.0
// Small occupancy grids for tests.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "pipeline/base/random.h"
#include "pipeline/io/grid_io.h"

namespace nightmap {

// All cells free.
inline OccupancyGrid FreeGrid(int width,
                              int height,
                              double resolution_m,
                              const Eigen::Vector2d& origin_in_map = Eigen::Vector2d::Zero()) {
  OccupancyGrid grid{width, height, resolution_m, origin_in_map, {}};
  grid.cells.assign(grid.Index(0, height), kFreeCell);
  return grid;
}

// The cells from (x0, y0) to before (x1, y1), as far as the grid has them.
inline void FillCells(int x0, int y0, int x1, int y1, CellValue value, OccupancyGrid* grid) {
  for (int y = std::max(y0, 0); y < std::min(y1, grid->height); ++y) {
    for (int x = std::max(x0, 0); x < std::min(x1, grid->width); ++x) {
      grid->cells[grid->Index(x, y)] = value;
    }
  }
}

// Rows from top (largest y) to bottom: '.' free, '#' occupied, '?' unknown. Cells of 0.1 m, lower
// left corner at (1, 2) m.
inline OccupancyGrid GridFromText(const std::vector<std::string>& rows) {
  OccupancyGrid grid{
      static_cast<int>(rows[0].size()), static_cast<int>(rows.size()), 0.1, {1, 2}, {}};
  for (auto row = rows.rbegin(); row != rows.rend(); ++row) {
    for (const char c : *row) {
      grid.cells.push_back(c == '#' ? kOccupiedCell : c == '?' ? kUnknownCell : kFreeCell);
    }
  }
  return grid;
}

// Each cell on its own occupied, unknown or free.
inline OccupancyGrid RandomGrid(
    Random& random, int width, int height, double occupied_ratio, double unknown_ratio = 0) {
  OccupancyGrid grid = FreeGrid(width, height, 0.05);
  for (std::uint8_t& cell : grid.cells) {
    const double draw = random.Uniform();
    if (draw < occupied_ratio + unknown_ratio) cell = kUnknownCell;
    if (draw < occupied_ratio) cell = kOccupiedCell;
  }
  return grid;
}

}  // namespace nightmap
