// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/theta_star.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "stages/plan/plan/block_field.h"
#include "stages/plan/plan/pull_tight.h"
#include "tests/stages/plan/plan/office_floor.h"
#include "tests/stages/plan/plan/reference_path.h"
#include "tests/stages/plan/plan/scene.h"

namespace nightmap::theta_star_test {

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

// The cost of a path from cell to cell.
std::int64_t StepsCost(const CostMap& map, const std::vector<Eigen::Vector2i>& cells) {
  std::int64_t cost = 0;
  for (std::size_t i = 1; i < cells.size(); ++i) {
    const Eigen::Vector2i step = cells[i] - cells[i - 1];
    EXPECT_EQ(step.cwiseAbs().maxCoeff(), 1);
    EXPECT_TRUE(map.IsFree(cells[i]));
    EXPECT_TRUE(map.IsFree({cells[i].x(), cells[i - 1].y()}));
    EXPECT_TRUE(map.IsFree({cells[i - 1].x(), cells[i].y()}));
    const bool diagonal = step.x() != 0 && step.y() != 0;
    cost += (diagonal ? SearchCost::kDiagonal : SearchCost::kStraight) *
            (std::int64_t{map.costs[map.Index(cells[i])]} + map.costs[map.Index(cells[i - 1])]);
  }
  return cost;
}

TEST(Search, FindsWhatDijkstraFinds) {
  int num_found = 0;
  int num_unreachable = 0;
  double any_angle_cost = 0;
  double grid_cost = 0;
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    const CostMap map = RandomMap(seed);
    if (!HasFree(map)) continue;
    Random random(seed, 1);
    const Eigen::Vector2i start = RandomFreeCell(random, map);
    const auto costs = DijkstraCosts(map, start);
    const auto labels = LabelReachable(map);
    for (int i = 0; i < 5; ++i) {
      SCOPED_TRACE(testing::Message() << seed << " " << i);
      const Eigen::Vector2i goal = RandomFreeCell(random, map);
      const SearchResult on_grid = FindPath(map, start, goal, Steps::kCellToCell);
      const SearchResult back = FindPath(map, goal, start, Steps::kCellToCell);
      const SearchResult result = FindPath(map, start, goal, Steps::kAnyAngle);
      const bool is_reachable = costs[map.Index(goal)] >= 0;
      EXPECT_EQ(labels[map.Index(start)] == labels[map.Index(goal)], is_reachable);
      for (const auto& search : {on_grid, back, result}) ASSERT_EQ(search.found, is_reachable);
      ++(is_reachable ? num_found : num_unreachable);
      if (!is_reachable) continue;
      EXPECT_EQ(on_grid.cost_cells, SearchCost::InCells(costs[map.Index(goal)]));
      EXPECT_EQ(on_grid.cost_cells, SearchCost::InCells(StepsCost(map, on_grid.cells)));
      EXPECT_EQ(on_grid.cost_cells, back.cost_cells);
      // Infinite if a line touched a cell that is not free.
      EXPECT_NEAR(CostOf(map, Centres(result.cells)), result.cost_cells, 1e-6);
      for (const auto& cells : {on_grid.cells, result.cells}) {
        EXPECT_EQ(cells.front(), start);
        EXPECT_EQ(cells.back(), goal);
      }
      any_angle_cost += result.cost_cells;
      grid_cost += on_grid.cost_cells;
    }
  }
  EXPECT_GT(num_found, 800);
  EXPECT_GT(num_unreachable, 100);
  EXPECT_LT(any_angle_cost, 1.05 * grid_cost);
}

TEST(Search, DoesNotCutCorners) {
  const auto map_of = [](const std::vector<std::string>& rows) {
    return MakeCostMap(GridFromText(rows), {.clearance_weight = 0}, 0, 1);
  };
  const CostMap map = map_of({"...",  //
                              ".#.",
                              "..."});
  EXPECT_EQ(FindPath(map, {0, 0}, {2, 2}, Steps::kCellToCell).cells.size(), 5);
  const CostMap gap = map_of({".#.",  //
                              "#..",
                              "..."});
  for (const Steps steps : {Steps::kCellToCell, Steps::kAnyAngle}) {
    EXPECT_FALSE(FindPath(gap, {0, 2}, {2, 2}, steps).found);
  }
}

// Work, not seconds: sanitizers and busy machines must not fail it.
TEST(Search, ExpandsFewerCellsThanWithoutTheGoalInView) {
  Random random(9);
  const CostMap map = MakeCostMap(Building(random, 300, 100), CostOptions{}, 0.25, 1);
  Eigen::Vector2i start(150, 150);
  while (!map.IsFree(start)) ++start.x();
  const auto costs = DijkstraCosts(map, start);
  std::size_t num_informed = 0;
  std::size_t num_uninformed = 0;
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector2i goal = RandomFreeCell(random, map);
    const std::int64_t cost_of_goal = costs[map.Index(goal)];
    if (cost_of_goal < 0) continue;
    const auto is_nearer = [&](std::int64_t cost) { return cost >= 0 && cost < cost_of_goal; };
    num_informed += FindPath(map, start, goal, Steps::kCellToCell).num_expanded;
    num_uninformed += static_cast<std::size_t>(std::ranges::count_if(costs, is_nearer));
  }
  EXPECT_GT(num_uninformed, 100000U);
  EXPECT_LT(num_informed, num_uninformed / 2);
}

// In the open it is the straight line, whatever the direction, once it is pulled tight.
TEST(AnyAngle, IsStraightWhereNothingIsInTheWay) {
  const CostMap map = MakeCostMap(FreeGrid(100, 90, 0.05), {.unknown = "allowed"}, 0.2, 1);
  Random random(3);
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector2i start = RandomFreeCell(random, map);
    const Eigen::Vector2i goal = RandomFreeCell(random, map);
    const double straight = (goal - start).cast<double>().norm();
    const auto result = FindPath(map, start, goal, Steps::kAnyAngle);
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
    const SearchResult on_grid = FindPath(map, start, goal, Steps::kCellToCell);
    if (!on_grid.found || (goal - start).cast<double>().norm() < 200) continue;
    const SearchResult result = FindPath(map, start, goal, Steps::kAnyAngle);
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

}  // namespace nightmap::theta_star_test
