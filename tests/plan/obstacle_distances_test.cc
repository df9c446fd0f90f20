// SPDX-License-Identifier: Apache-2.0
#include "pipeline/plan/obstacle_distances.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>

#include "pipeline/base/random.h"
#include "tests/small_grids.h"

namespace nightmap::obstacle_distances_test {

// Between the squares of two cells.
int SquaredGap(int dx, int dy) {
  const int gap_x = std::max(std::abs(dx) - 1, 0);
  const int gap_y = std::max(std::abs(dy) - 1, 0);
  return gap_x * gap_x + gap_y * gap_y;
}

// Calls visit(x, y) for the cells that are obstacles, also those of a rim around the grid.
void ForObstacles(const OccupancyGrid& grid,
                  bool unknown_is_obstacle,
                  const std::function<void(int, int)>& visit) {
  for (int y = -1; y <= grid.height; ++y) {
    for (int x = -1; x <= grid.width; ++x) {
      const int value = grid.Contains({x, y}) ? grid.At({x, y}) : int{kUnknownCell};
      if (value == kOccupiedCell || (value == kUnknownCell && unknown_is_obstacle)) visit(x, y);
    }
  }
}

int BruteForce(const OccupancyGrid& grid, const Eigen::Vector2i& cell, bool unknown_is_obstacle) {
  int least = std::numeric_limits<int>::max();
  ForObstacles(grid, unknown_is_obstacle, [&](int x, int y) {
    least = std::min(least, SquaredGap(x - cell.x(), y - cell.y()));
  });
  return least;
}

// From a point to the nearest obstacle's square, in cells; all beyond the rim is as the rim is.
double BruteForceFromPoint(const OccupancyGrid& grid,
                           const Eigen::Vector2d& point,
                           bool unknown_is_obstacle) {
  const bool is_outside = !grid.Contains(point.array().floor().cast<int>().matrix());
  if (is_outside && unknown_is_obstacle) return 0;
  double least = 1e9;
  ForObstacles(grid, unknown_is_obstacle, [&](int x, int y) {
    const Eigen::Vector2d low(x, y);
    const Eigen::Vector2d inside = point.cwiseMax(low).cwiseMin(low + Eigen::Vector2d::Ones());
    least = std::min(least, (inside - point).norm());
  });
  return least;
}

// Sides shorter and longer than the number of cells that are computed together.
OccupancyGrid RandomSizedGrid(Random& random) {
  const auto side = [&] { return 1 + static_cast<int>(random.Index(80)); };
  const int width = side();
  const double occupied_ratio = random.Uniform() < 0.5 ? 0.002 : 0.05;
  return RandomGrid(random, width, side(), occupied_ratio, 0.01);
}

void ForEachCell(const OccupancyGrid& grid,
                 const std::function<void(const Eigen::Vector2i&)>& test) {
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) test({x, y});
  }
}

TEST(ObstacleDistances, AreExact) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Random random(seed);
    const OccupancyGrid grid = RandomSizedGrid(random);
    const bool unknown_is_obstacle = seed % 2 == 0;
    const ObstacleDistances distances(grid, unknown_is_obstacle, 1);
    ForEachCell(grid, [&](const Eigen::Vector2i& cell) {
      const int exact = BruteForce(grid, cell, unknown_is_obstacle);
      if (exact == std::numeric_limits<int>::max()) {
        EXPECT_GE(distances.Squared(cell), grid.width * grid.width);
      } else {
        EXPECT_EQ(distances.Squared(cell), exact) << seed << " " << cell.transpose();
      }
      EXPECT_EQ(distances.Squared(cell, 20), std::min(exact, 20));
    });
  }
}

// Also in obstacles, beyond the grid and on the borders of cells.
TEST(ObstacleDistances, OfPointsAreExactAndTellWhatFits) {
  int num_fitting = 0;
  int num_hitting = 0;
  for (std::uint64_t seed = 0; seed < 120; ++seed) {
    Random random(seed);
    const OccupancyGrid grid = RandomSizedGrid(random);
    const bool unknown_is_obstacle = seed % 2 == 0;
    const ObstacleDistances distances(grid, unknown_is_obstacle, 1);
    for (int i = 0; i < 40; ++i) {
      SCOPED_TRACE(testing::Message() << seed << " " << i);
      Eigen::Vector2d point(random.Uniform(-9, grid.width + 9),
                            random.Uniform(-9, grid.height + 9));
      if (i % 4 == 0) point.x() = std::round(point.x());
      const double exact_m =
          grid.resolution_m * BruteForceFromPoint(grid, point, unknown_is_obstacle);
      EXPECT_NEAR(distances.Clearance_m(point), std::min(exact_m, 100.0), 1e-9);
      const double radius_m = random.Uniform(0, 2.5);
      EXPECT_NEAR(distances.Clearance_m(point, radius_m), std::min(exact_m, radius_m), 1e-9);
      EXPECT_EQ(distances.Fits(point, radius_m), exact_m >= radius_m - 2e-6);
      EXPECT_TRUE(exact_m == 0 || distances.Fits(point, exact_m));
      EXPECT_FALSE(exact_m == 0 && distances.Fits(point, 1e-5));
      const Eigen::Vector2i own = point.array().floor().cast<int>();
      EXPECT_EQ(distances.Fits(point, 0), !distances.IsObstacle(own));
      ++(exact_m >= radius_m ? num_fitting : num_hitting);
    }
  }
  EXPECT_GT(num_fitting, 500);
  EXPECT_GT(num_hitting, 500);
}

// Includes caps whose sums need more than 16 bits.
TEST(ObstacleDistances, OfARowAreExactUpToTheCap) {
  int num_below = 0;
  int num_capped = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Random random(seed);
    const OccupancyGrid grid = RandomSizedGrid(random);
    const ObstacleDistances distances(grid, seed % 2 == 0, 1);
    for (const std::int32_t cap : {0, 1, 2, 10, 225, 181 * 181, 181 * 181 + 1, 300 * 300}) {
      std::vector<std::uint32_t> row;
      ForEachCell(grid, [&](const Eigen::Vector2i& cell) {
        if (cell.x() == 0) distances.SquaredOfRow(cell.y(), cap, row);
        const std::int32_t exact = distances.Squared(cell);
        const auto squared = static_cast<std::int32_t>(row[static_cast<std::size_t>(cell.x())]);
        ASSERT_EQ(std::min(squared, cap), std::min(exact, cap)) << seed << " " << cap;
        ++(exact < cap ? num_below : num_capped);
      });
    }
  }
  EXPECT_GT(num_below, 10000);
  EXPECT_GT(num_capped, 10000);
}

// Far across an empty hall, where sums of squares are largest.
TEST(ObstacleDistances, AreExactFarFromObstacles) {
  Random random(0);
  OccupancyGrid grid = RandomGrid(random, 700, 3, 0);
  grid.cells[0] = kOccupiedCell;
  const ObstacleDistances distances(grid, false, 1);
  for (const std::int32_t cap : {181 * 181, 600 * 600}) {
    std::vector<std::uint32_t> row;
    distances.SquaredOfRow(2, cap, row);
    for (int x = 0; x < grid.width; ++x) {
      EXPECT_EQ(distances.Squared({x, 2}), SquaredGap(x, 2));
      const auto squared = static_cast<std::int32_t>(row[static_cast<std::size_t>(x)]);
      EXPECT_EQ(std::min(squared, cap), std::min(SquaredGap(x, 2), cap));
    }
  }
}

TEST(ObstacleDistances, SameAtAnyNumberOfThreads) {
  Random random(4);
  const OccupancyGrid grid = RandomGrid(random, 600, 600, 0.01);
  const ObstacleDistances one(grid, true, 1);
  const ObstacleDistances four(grid, true, 4);
  ForEachCell(
      grid, [&](const Eigen::Vector2i& cell) { ASSERT_EQ(one.Squared(cell), four.Squared(cell)); });
}

}  // namespace nightmap::obstacle_distances_test
