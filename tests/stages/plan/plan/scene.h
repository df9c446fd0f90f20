// SPDX-License-Identifier: Apache-2.0
// Small grids for the tests of the plan stage.
#pragma once

#include <algorithm>

#include "pipeline/base/random.h"
#include "pipeline/io/grid_io.h"
#include "stages/plan/plan/cost_map.h"
#include "tests/small_grids.h"

namespace nightmap {

// A building: rooms of `room` cells a side, doors in every wall, tables inside.
inline OccupancyGrid Building(Random& random, int side, int room) {
  OccupancyGrid grid = RandomGrid(random, side, side, 0);
  const auto fill = [&](int x0, int y0, int width, int height, CellValue value) {
    FillCells(x0, y0, x0 + width, y0 + height, value, &grid);
  };
  const auto inside = [&](int extent) {
    return 4 + static_cast<int>(random.Index(static_cast<std::size_t>(room - extent - 8)));
  };
  for (int at = 0; at < side; at += room) {
    fill(at, 0, 3, side, kOccupiedCell);
    fill(0, at, side, 3, kOccupiedCell);
  }
  for (int y = 0; y < side; y += room) {
    for (int x = 0; x < side; x += room) {
      fill(x, y + inside(20), 3, 20, kFreeCell);
      fill(x + inside(20), y, 20, 3, kFreeCell);
      for (int i = 0; i < 4; ++i) fill(x + inside(24), y + inside(12), 24, 12, kOccupiedCell);
    }
  }
  return grid;
}

// A random free cell; the map must have one.
inline Eigen::Vector2i RandomFreeCell(Random& random, const CostMap& map) {
  while (true) {
    const std::size_t index = random.Index(map.Size());
    if (map.costs[index] > 0) return map.Cell(index);
  }
}

inline bool HasFree(const CostMap& map) {
  return std::any_of(map.costs.begin(), map.costs.end(), [](auto cost) { return cost > 0; });
}

// Small, with all kinds of options.
inline CostMap RandomMap(std::uint64_t seed) {
  Random random(seed);
  const int width = 5 + static_cast<int>(random.Index(30));
  const int height = 5 + static_cast<int>(random.Index(30));
  const OccupancyGrid grid = RandomGrid(random, width, height, 0.2 * random.Uniform(), 0.05);
  CostOptions options;
  const double radius_m = 0.05 * static_cast<double>(random.Index(3));
  options.clearance_weight = seed % 2 == 0 ? 0.0 : random.Uniform(0, 10);
  options.clearance_m = random.Uniform(0, 0.4);
  options.unknown = random.Uniform() < 0.5 ? "forbidden" : seed % 3 == 0 ? "costed" : "allowed";
  return MakeCostMap(grid, options, radius_m, 1);
}

}  // namespace nightmap
