// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/astar.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/stages/plan/plan/reference_path.h"
#include "tests/stages/plan/plan/scene.h"

namespace nightmap {
namespace astar_test {

std::int64_t CostOf(const CostMap& map, const std::vector<Eigen::Vector2i>& cells) {
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
  for (std::uint64_t seed = 0; seed < 400; ++seed) {
    const CostMap map = RandomMap(seed);
    if (!HasFree(map)) continue;
    Random random(seed, 1);
    const Eigen::Vector2i start = RandomFreeCell(random, map);
    const auto costs = DijkstraCosts(map, start);
    for (int i = 0; i < 5; ++i) {
      const Eigen::Vector2i goal = RandomFreeCell(random, map);
      const SearchResult result = FindPath(map, start, goal);
      ASSERT_EQ(result.found, costs[map.Index(goal)] >= 0) << seed;
      if (!result.found) {
        ++num_unreachable;
        const auto num_reached = std::ranges::count_if(costs, [](auto cost) { return cost >= 0; });
        EXPECT_GE(result.num_expanded, static_cast<std::size_t>(num_reached)) << seed;
        continue;
      }
      ++num_found;
      EXPECT_EQ(result.cost_cells, SearchCost::InCells(costs[map.Index(goal)])) << seed;
      EXPECT_EQ(result.cost_cells, SearchCost::InCells(CostOf(map, result.cells))) << seed;
      EXPECT_EQ(result.cells.front(), start);
      EXPECT_EQ(result.cells.back(), goal);
    }
  }
  EXPECT_GT(num_found, 500);
  EXPECT_GT(num_unreachable, 50);
}

TEST(Search, ThereAndBackCostTheSame) {
  for (std::uint64_t seed = 1000; seed < 1200; ++seed) {
    const CostMap map = RandomMap(seed);
    if (!HasFree(map)) continue;
    Random random(seed, 1);
    const Eigen::Vector2i a = RandomFreeCell(random, map);
    const Eigen::Vector2i b = RandomFreeCell(random, map);
    const SearchResult there = FindPath(map, a, b);
    const SearchResult back = FindPath(map, b, a);
    EXPECT_EQ(there.found, back.found) << seed;
    EXPECT_EQ(there.cost_cells, back.cost_cells) << seed;
  }
}

TEST(Search, ReachableLabelsTellWhichSearchesSucceed) {
  for (std::uint64_t seed = 2000; seed < 2200; ++seed) {
    const CostMap map = RandomMap(seed);
    if (!HasFree(map)) continue;
    const auto labels = LabelReachable(map);
    Random random(seed, 1);
    for (int i = 0; i < 5; ++i) {
      const Eigen::Vector2i a = RandomFreeCell(random, map);
      const Eigen::Vector2i b = RandomFreeCell(random, map);
      EXPECT_EQ(FindPath(map, a, b).found, labels[map.Index(a)] == labels[map.Index(b)]) << seed;
    }
  }
}

TEST(Search, DoesNotCutCorners) {
  CostOptions options;
  options.clearance_weight = 0;
  const CostMap map = MakeCostMap(GridFromText({"...",  //
                                                ".#.",
                                                "..."}),
                                  options,
                                  0,
                                  1);
  EXPECT_EQ(FindPath(map, {0, 0}, {2, 2}).cells.size(), 5);
  const CostMap gap = MakeCostMap(GridFromText({".#.",  //
                                                "#..",
                                                "..."}),
                                  options,
                                  0,
                                  1);
  EXPECT_FALSE(FindPath(gap, {0, 2}, {2, 2}).found);
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
    const SearchResult result = FindPath(map, start, goal);
    ASSERT_TRUE(result.found);
    num_informed += result.num_expanded;
    num_uninformed += static_cast<std::size_t>(std::ranges::count_if(costs, is_nearer));
  }
  EXPECT_GT(num_uninformed, 100000U);
  EXPECT_LT(num_informed, num_uninformed / 2);
}

}  // namespace astar_test
}  // namespace nightmap
