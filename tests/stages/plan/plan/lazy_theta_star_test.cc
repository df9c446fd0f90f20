// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/lazy_theta_star.h"

#include <gtest/gtest.h>

#include "stages/plan/plan/block_field.h"
#include "stages/plan/plan/pull_tight.h"
#include "tests/stages/plan/plan/office_floor.h"
#include "tests/stages/plan/plan/reference_path.h"
#include "tests/stages/plan/plan/scene.h"

namespace nightmap {
namespace lazy_theta_star_test {

TEST(BlockField, ReachesWhatTheFloodReaches) {
  int num_cut_off = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const CostMap map = RandomMap(seed);
    if (!HasFree(map)) continue;
    const auto labels = LabelReachable(map);
    Random random(seed, 1);
    const Eigen::Vector2i goal = RandomFreeCell(random, map);
    const BlockField field(map, goal);
    EXPECT_EQ(field.CostToGoal(goal), 0);
    for (std::size_t i = 0; i < map.Size(); ++i) {
      if (map.costs[i] == 0) continue;
      const bool reaches = labels[i] == labels[map.Index(goal)];
      ASSERT_EQ(field.Reaches(map.Cell(i)), reaches) << seed << " " << i;
      num_cut_off += reaches ? 0 : 1;
    }
  }
  EXPECT_GT(num_cut_off, 500);
}

TEST(AnyAngle, FindsAPathExactlyWhenThereIsOne) {
  int num_found = 0;
  int num_unreachable = 0;
  double any_angle_cost = 0;
  double grid_cost = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    const CostMap map = RandomMap(seed);
    if (!HasFree(map)) continue;
    Random random(seed, 1);
    for (int i = 0; i < 5; ++i) {
      const Eigen::Vector2i start = RandomFreeCell(random, map);
      const Eigen::Vector2i goal = RandomFreeCell(random, map);
      const SearchResult on_grid = FindPath(map, start, goal);
      const SearchResult result = FindAnyAnglePath(map, start, goal);
      ASSERT_EQ(result.found, on_grid.found) << seed << " " << i;
      ++(result.found ? num_found : num_unreachable);
      if (!result.found) continue;
      EXPECT_EQ(result.cells.front(), start);
      EXPECT_EQ(result.cells.back(), goal);
      // Infinite if a line touched a cell that is not free.
      EXPECT_NEAR(CostOf(map, Centres(result.cells)), result.cost_cells, 1e-6) << seed << " " << i;
      any_angle_cost += result.cost_cells;
      grid_cost += on_grid.cost_cells;
    }
  }
  EXPECT_GT(num_found, 800);
  EXPECT_GT(num_unreachable, 100);
  EXPECT_LT(any_angle_cost, 1.05 * grid_cost);
}

// In the open it is the straight line, whatever the direction, once it is pulled tight.
TEST(AnyAngle, IsStraightWhereNothingIsInTheWay) {
  OccupancyGrid grid{100, 90, 0.05, Eigen::Vector2d::Zero(), {}};
  grid.cells.assign(9000, kFreeCell);
  CostOptions options;
  options.unknown = "allowed";
  const CostMap map = MakeCostMap(grid, options, 0.2, 1);
  Random random(3);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector2i start = RandomFreeCell(random, map);
    const Eigen::Vector2i goal = RandomFreeCell(random, map);
    const double straight = (goal - start).cast<double>().norm();
    const auto result = FindAnyAnglePath(map, start, goal);
    EXPECT_NEAR(result.cost_cells, LengthOf(Centres(result.cells)), 1e-6);
    EXPECT_NEAR(LengthOf(Tighten(map, Centres(result.cells))), straight, 1e-6);
  }
}

// Compares work and length, not seconds, on floors rotated against the grid like real ones.
TEST(AnyAngle, IsShorterThanAStarAndSearchesLess) {
  const auto grid = OfficeFloor(1, 38).ToGrid(50, 0.05, 0.35);
  const CostMap map = MakeCostMap(grid, {}, 0.25, 1);
  Random random(5);
  double any_angle_length = 0;
  double grid_length = 0;
  double any_angle_cost = 0;
  double grid_cost = 0;
  std::size_t num_any_angle = 0;
  std::size_t num_grid = 0;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector2i start = RandomFreeCell(random, map);
    const Eigen::Vector2i goal = RandomFreeCell(random, map);
    const SearchResult on_grid = FindPath(map, start, goal);
    if (!on_grid.found || (goal - start).cast<double>().norm() < 200) continue;
    const SearchResult result = FindAnyAnglePath(map, start, goal);
    any_angle_length += LengthOf(Centres(result.cells));
    grid_length += LengthOf(Centres(on_grid.cells));
    any_angle_cost += result.cost_cells;
    grid_cost += on_grid.cost_cells;
    num_any_angle += result.num_expanded;
    num_grid += on_grid.num_expanded;
  }
  EXPECT_GT(grid_length, 5000);
  EXPECT_LT(any_angle_length, 0.97 * grid_length);
  EXPECT_LT(any_angle_cost, grid_cost);
  EXPECT_LT(num_any_angle, num_grid / 4);
}

}  // namespace lazy_theta_star_test
}  // namespace nightmap
