// SPDX-License-Identifier: Apache-2.0
// Small occupancy grids for tests.
#pragma once

#include <string>
#include <vector>

#include "pipeline/base/random.h"
#include "pipeline/io/grid_io.h"

namespace nightmap {

// Rows from top (largest y) to bottom: '.' free, '#' occupied, '?' unknown. Cells of 0.1 m, lower
// left corner at (1, 2) m.
inline OccupancyGrid GridFromText(const std::vector<std::string>& rows) {
  OccupancyGrid grid;
  grid.width = static_cast<int>(rows[0].size());
  grid.height = static_cast<int>(rows.size());
  grid.resolution_m = 0.1;
  grid.origin_in_map = {1, 2};
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
  OccupancyGrid grid;
  grid.width = width;
  grid.height = height;
  for (int i = 0; i < width * height; ++i) {
    const double draw = random.Uniform();
    grid.cells.push_back(draw < occupied_ratio                   ? kOccupiedCell
                         : draw < occupied_ratio + unknown_ratio ? kUnknownCell
                                                                 : kFreeCell);
  }
  return grid;
}

}  // namespace nightmap
