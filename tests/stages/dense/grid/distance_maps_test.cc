// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/grid/distance_maps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "pipeline/base/random.h"

namespace nightmap::distance_maps_test {

OccupancyGrid RandomGrid(std::uint64_t seed) {
  Random random(seed);
  OccupancyGrid grid;
  grid.width = 5 + static_cast<int>(random.Index(25));
  grid.height = 5 + static_cast<int>(random.Index(25));
  grid.resolution_m = 0.1;
  for (int i = 0; i < grid.width * grid.height; ++i) {
    const double draw = random.Uniform();
    grid.cells.push_back(draw < 0.1 ? kOccupiedCell : draw < 0.15 ? kUnknownCell : kFreeCell);
  }
  return grid;
}

// Smallest distance from a cell to one that fits, `frame` cells around the grid included.
template <typename Fits>
double Nearest_m(const OccupancyGrid& grid, int x, int y, int frame, const Fits& fits) {
  double best = std::numeric_limits<double>::infinity();
  for (int v = -frame; v < grid.height + frame; ++v) {
    for (int u = -frame; u < grid.width + frame; ++u) {
      const bool is_target = grid.Contains({u, v}) ? fits(grid.At({u, v})) : true;
      if (is_target) best = std::min(best, grid.resolution_m * std::hypot(u - x, v - y));
    }
  }
  return best;
}

TEST(DistanceMaps, EqualsBruteForceAtAnyNumberOfThreads) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const OccupancyGrid grid = RandomGrid(seed);
    const auto clearance_m = Clearance_m(grid, 1);
    const auto signed_m = SignedDistance_m(grid, 1);
    for (int y = 0; y < grid.height; ++y) {
      for (int x = 0; x < grid.width; ++x) {
        const std::size_t i = grid.Index(x, y);
        const bool occupied = grid.cells[i] == kOccupiedCell;
        EXPECT_NEAR(clearance_m[i],
                    Nearest_m(grid, x, y, 1, [](int cell) { return cell != kFreeCell; }),
                    1e-6);
        const double other_m =
            Nearest_m(grid, x, y, 0, [&](int cell) { return (cell == kOccupiedCell) != occupied; });
        EXPECT_NEAR(signed_m[i], occupied ? -other_m : other_m, 1e-6);
      }
    }
    EXPECT_EQ(Clearance_m(grid, 4), clearance_m);
    EXPECT_EQ(SignedDistance_m(grid, 4), signed_m);
  }
}

TEST(DistanceMaps, WithoutAnObstacleItIsFarAndFinite) {
  OccupancyGrid grid = RandomGrid(3);
  for (auto& cell : grid.cells) cell = kFreeCell;
  for (const float distance_m : SignedDistance_m(grid, 1)) {
    EXPECT_TRUE(std::isfinite(distance_m));
    EXPECT_GE(distance_m, 0.1F * static_cast<float>(grid.width));
  }
}

}  // namespace nightmap::distance_maps_test
