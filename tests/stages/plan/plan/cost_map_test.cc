// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/cost_map.h"

#include <gtest/gtest.h>

#include "tests/stages/plan/plan/scene.h"

namespace nightmap::cost_map_test {

TEST(CostMap, FreeMeansTheRadiusFits) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Random random(seed);
    const OccupancyGrid grid = RandomGrid(random, 20, 15, 0.03);
    const double radius_m = seed == 0 ? 0 : random.Uniform(0, 0.3);
    const CostMap map = MakeCostMap(grid, {.unknown = "allowed"}, radius_m, 1);
    const ObstacleDistances distances(grid, false, 1);
    for (std::size_t i = 0; i < grid.cells.size(); ++i) {
      const Eigen::Vector2i cell(static_cast<int>(i) % grid.width,
                                 static_cast<int>(i) / grid.width);
      const double clearance_m = grid.resolution_m * std::sqrt(distances.Squared(cell));
      const bool fits = grid.cells[i] == kFreeCell && clearance_m >= radius_m;
      EXPECT_EQ(map.IsFree(cell), fits) << seed << " " << i;
      EXPECT_NEAR(map.Clearance_m(cell), clearance_m, 1e-9);
    }
  }
}

// Wherever in a free cell the robot is, also at its very corners.
TEST(CostMap, NoPointOfAFreeCellTouchesAnObstacle) {
  int num_checked = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Random random(seed);
    const OccupancyGrid grid = RandomGrid(random, 25, 20, 0.02, 0.01);
    const double radius_m = random.Uniform(0.01, 0.3);
    const CostOptions options{.unknown = seed % 2 == 0 ? "forbidden" : "costed"};
    const CostMap map = MakeCostMap(grid, options, radius_m, 1);
    for (std::size_t i = 0; i < map.Size(); ++i) {
      if (map.costs[i] == 0) continue;
      for (int k = 0; k < 8; ++k) {
        const auto draw = [&] {
          return k < 4 ? random.Uniform(-0.5, 0.5) : k % 2 == 0 ? -0.4999 : 0.4999;
        };
        const double x = draw();
        const Eigen::Vector2d offset(x, k < 6 ? draw() : -x);
        const Eigen::Vector2d point = grid.CenterInMap(map.Cell(i)) + grid.resolution_m * offset;
        EXPECT_TRUE(map.distances.Fits(grid.ToCells(point), radius_m)) << seed;
        ++num_checked;
      }
    }
  }
  EXPECT_GT(num_checked, 10000);
}

TEST(CostMap, CostFallsWithTheDistanceToObstacles) {
  const CostOptions options{
      .unknown = "allowed", .clearance_m = 0.8, .clearance_weight = 3, .margin_m = 0};
  const CostMap map = MakeCostMap(GridFromText({"#..............."}), options, 0.2, 1);
  const auto cost = [&](int x) { return map.costs[map.Index({x, 0})]; };
  for (const int x : {0, 1, 2}) EXPECT_EQ(cost(x), 0);
  EXPECT_EQ(cost(3), 4 * CostMap::kUnitCost);  // two cells between it and the obstacle
  for (int x = 4; x <= 9; ++x) EXPECT_LT(cost(x), cost(x - 1));
  for (int x = 9; x < 16; ++x) EXPECT_EQ(cost(x), CostMap::kUnitCost);
}

TEST(CostMap, LessRoomThanTheMarginCostsMore) {
  const OccupancyGrid grid = GridFromText({"#..............."});
  CostOptions options{.unknown = "allowed"};
  const auto costs = [&](double margin_m, double weight) {
    options.margin_m = margin_m;
    options.margin_weight = weight;
    return MakeCostMap(grid, options, 0.2, 1);
  };
  for (const double clearance_m : {0.0, 0.75}) {  // also where the margin reaches farther
    options.clearance_m = clearance_m;
    const CostMap plain = costs(0.25, 0);
    const CostMap map = costs(0.25, 20);
    for (int x = 0; x < 16; ++x) {
      const std::size_t index = map.Index({x, 0});
      const double clearance = plain.Clearance_m({x, 0});
      const bool is_narrow = clearance > 0.2 - 1e-9 && clearance < 0.45 - 1e-9;
      EXPECT_EQ(map.costs[index], plain.costs[index] + (is_narrow ? 20 * CostMap::kUnitCost : 0))
          << x;
    }
  }
  const auto values = [](const CostMap& map) {
    return std::vector(map.costs.begin(), map.costs.end());
  };
  EXPECT_EQ(values(costs(0, 20)), values(costs(0, 0)));
}

TEST(CostMap, UnknownIsForbiddenAllowedOrCosted) {
  const OccupancyGrid grid = GridFromText({"..........", "....??....", ".........."});
  CostOptions options{.unknown_weight = 3, .clearance_weight = 0};
  const auto cost = [&](const std::string& unknown, const Eigen::Vector2i& cell) {
    options.unknown = unknown;
    const CostMap map = MakeCostMap(grid, options, 0, 1);
    return map.costs[map.Index(cell)] / CostMap::kUnitCost;
  };
  EXPECT_EQ(cost("forbidden", {4, 1}), 0);
  EXPECT_EQ(cost("allowed", {4, 1}), 1);
  EXPECT_EQ(cost("costed", {4, 1}), 4);
  for (const char* unknown : {"forbidden", "allowed", "costed"})
    EXPECT_EQ(cost(unknown, {1, 1}), 1);
}

TEST(CostMap, SameAtAnyNumberOfThreads) {
  Random random(2);
  const OccupancyGrid grid = Building(random, 300, 60);
  EXPECT_EQ(MakeCostMap(grid, {}, 0.2, 1).costs, MakeCostMap(grid, {}, 0.2, 4).costs);
}

}  // namespace nightmap::cost_map_test
