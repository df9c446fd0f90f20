// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "stages/plan/shorten.h"
#include "tests/stages/plan/scene.h"

namespace nightmap {
namespace {

CostMap RandomMap(std::uint64_t seed) {
  Random random(seed);
  const int width = 5 + static_cast<int>(random.Index(30));
  const int height = 5 + static_cast<int>(random.Index(30));
  const OccupancyGrid grid = RandomGrid(random, width, height, 0.2 * random.Uniform(), 0.05);
  RobotOptions options;
  options.robot_radius_m = 0.05 * static_cast<double>(random.Index(3));
  options.clearance_weight = seed % 2 == 0 ? 0.0 : random.Uniform(0, 10);
  options.clearance_m = random.Uniform(0, 0.4);
  options.unknown_is_obstacle = random.Uniform() < 0.5;
  return MakeCostMap(grid, options, 1);
}

bool HasFree(const CostMap& map) {
  return std::any_of(map.costs.begin(), map.costs.end(), [](auto cost) { return cost > 0; });
}

// Costs from one cell to all, by repeated relaxation in the order of an ordered set: slow, plain.
std::map<std::size_t, std::int64_t> Dijkstra(const CostMap& map, const Eigen::Vector2i& start) {
  std::map<std::size_t, std::int64_t> costs = {{map.Index(start), 0}};
  std::set<std::pair<std::int64_t, std::size_t>> open = {{0, map.Index(start)}};
  while (!open.empty()) {
    const auto [cost, index] = *open.begin();
    open.erase(open.begin());
    const Eigen::Vector2i cell = map.Cell(index);
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const Eigen::Vector2i next(cell.x() + dx, cell.y() + dy);
        if (!map.IsFree(next) || !map.IsFree({next.x(), cell.y()}) ||
            !map.IsFree({cell.x(), next.y()})) {
          continue;
        }
        const std::int64_t length = dx == 0 && dy == 0   ? 0
                                    : dx != 0 && dy != 0 ? SearchCost::kDiagonal
                                                         : SearchCost::kStraight;
        const std::int64_t total =
            cost + length * (std::int64_t{map.costs[index]} + map.costs[map.Index(next)]);
        const auto it = costs.find(map.Index(next));
        if (it != costs.end() && it->second <= total) continue;
        if (it != costs.end()) open.erase({it->second, it->first});
        costs[map.Index(next)] = total;
        open.insert({total, map.Index(next)});
      }
    }
  }
  return costs;
}

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
    const auto costs = Dijkstra(map, start);
    for (int i = 0; i < 5; ++i) {
      const Eigen::Vector2i goal = RandomFreeCell(random, map);
      const SearchResult result = FindPath(map, start, goal);
      ASSERT_EQ(result.found, costs.count(map.Index(goal)) > 0) << seed;
      if (!result.found) {
        ++num_unreachable;
        EXPECT_EQ(result.num_expanded, costs.size()) << seed;
        EXPECT_TRUE(costs.count(map.Index(result.nearest_reached)) > 0) << seed;
        continue;
      }
      ++num_found;
      EXPECT_EQ(result.cost, costs.at(map.Index(goal))) << seed;
      EXPECT_EQ(result.cost, CostOf(map, result.cells)) << seed;
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
    EXPECT_EQ(there.cost, back.cost) << seed;
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
  RobotOptions options;
  options.robot_radius_m = 0;
  options.clearance_weight = 0;
  const CostMap map = MakeCostMap(GridFromText({"...",  //
                                                ".#.",
                                                "..."}),
                                  options,
                                  1);
  EXPECT_EQ(FindPath(map, {0, 0}, {2, 2}).cells.size(), 5);
  const CostMap gap = MakeCostMap(GridFromText({".#.",  //
                                                "#..",
                                                "..."}),
                                  options,
                                  1);
  EXPECT_FALSE(FindPath(gap, {0, 2}, {2, 2}).found);
}

TEST(CostMap, FreeMeansTheRadiusFits) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Random random(seed);
    const OccupancyGrid grid = RandomGrid(random, 20, 15, 0.03);
    RobotOptions options;
    options.robot_radius_m = random.Uniform(0, 0.3);
    options.unknown_is_obstacle = false;
    const CostMap map = MakeCostMap(grid, options, 1);
    for (std::size_t i = 0; i < map.Size(); ++i) {
      bool fits = grid.cells[i] == kFreeCell;
      for (std::size_t k = 0; k < map.Size(); ++k) {
        const double distance_m =
            (grid.CenterInMap(map.Cell(i)) - grid.CenterInMap(map.Cell(k))).norm();
        if (grid.cells[k] == kOccupiedCell && distance_m < options.robot_radius_m) fits = false;
      }
      EXPECT_EQ(map.costs[i] > 0, fits) << seed << " " << i;
    }
  }
}

TEST(CostMap, CostFallsWithTheDistanceToObstacles) {
  OccupancyGrid grid = GridFromText({"#..............."});
  RobotOptions options;
  options.unknown_is_obstacle = false;
  options.robot_radius_m = 0.2;
  options.clearance_m = 0.8;
  options.clearance_weight = 3;
  const CostMap map = MakeCostMap(grid, options, 1);
  EXPECT_EQ(map.costs[1], 0);
  EXPECT_EQ(map.costs[2], 4 * CostMap::kUnitCost);
  for (std::size_t i = 3; i <= 8; ++i) EXPECT_LT(map.costs[i], map.costs[i - 1]);
  for (std::size_t i = 8; i < 16; ++i) EXPECT_EQ(map.costs[i], CostMap::kUnitCost);
}

// Dense samples of the segment must lie in visited cells; the lengths add up.
TEST(Shorten, SegmentVisitsEveryCellItTouches) {
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const bool on_grid = i % 4 == 0;  // half-integer ends cross corners exactly
    const auto draw = [&] {
      const double value = random.Uniform(-9, 9);
      return on_grid ? std::floor(value) + 0.5 : value;
    };
    const Eigen::Vector2d a(draw(), draw());
    const Eigen::Vector2d b(draw(), draw());
    std::set<std::pair<int, int>> visited;
    double length = 0;
    VisitSegment(a, b, [&](const Eigen::Vector2i& cell, double part) {
      EXPECT_GE(part, -1e-9);
      visited.insert({cell.x(), cell.y()});
      length += part;
      return true;
    });
    EXPECT_NEAR(length, (b - a).norm(), 1e-9);
    for (int k = 0; k <= 1000; ++k) {
      const Eigen::Vector2d point = a + (b - a) * k / 1000;
      const Eigen::Vector2d nearest = point.array().round();
      if ((point - nearest).cwiseAbs().minCoeff() < 1e-9) continue;  // on a line of the grid
      EXPECT_TRUE(visited.count({static_cast<int>(std::floor(point.x())),
                                 static_cast<int>(std::floor(point.y()))}) > 0);
    }
  }
}

TEST(Shorten, CornerTouchesAllFourCells) {
  std::set<std::pair<int, int>> visited;
  VisitSegment({0.5, 0.5}, {1.5, 1.5}, [&](const Eigen::Vector2i& cell, double) {
    visited.insert({cell.x(), cell.y()});
    return true;
  });
  EXPECT_EQ(visited.size(), 4);
}

TEST(Shorten, StaysFreeAndIsNeverDearer) {
  int num_shorter = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const CostMap map = RandomMap(seed);
    if (!HasFree(map)) continue;
    Random random(seed, 1);
    const auto search = FindPath(map, RandomFreeCell(random, map), RandomFreeCell(random, map));
    if (!search.found) continue;
    std::vector<Eigen::Vector2d> route;
    for (const auto& cell : search.cells) {
      route.push_back(cell.cast<double>() + Eigen::Vector2d(0.5, 0.5));
    }
    const auto cost = [&](const std::vector<Eigen::Vector2d>& points) {
      double sum = 0;
      for (std::size_t i = 1; i < points.size(); ++i) {
        EXPECT_TRUE(IsSegmentFree(map, points[i - 1], points[i])) << seed;
        VisitSegment(points[i - 1], points[i], [&](const Eigen::Vector2i& cell, double length) {
          sum += length * map.costs[map.Index(cell)];
          return true;
        });
      }
      return sum / CostMap::kUnitCost;
    };
    const auto tight = Shorten(map, route);
    EXPECT_LE(cost(tight), cost(route) + 1e-4) << seed;
    EXPECT_EQ(tight.front(), route.front());
    EXPECT_EQ(tight.back(), route.back());
    num_shorter += cost(tight) < cost(route) - 0.1 ? 1 : 0;
    for (const auto& dense = Resample(tight); const auto& point : dense) {
      EXPECT_TRUE(map.IsFree(point.array().floor().cast<int>())) << seed;
    }
  }
  EXPECT_GT(num_shorter, 30);
}

TEST(Shorten, ResampledPointsAreAtMostOneCellApart) {
  const auto points = Resample({{0.5, 0.5}, {7.3, 2.1}, {7.3, 3.1}});
  for (std::size_t i = 1; i < points.size(); ++i) {
    EXPECT_LE((points[i] - points[i - 1]).norm(), 1 + 1e-9);
  }
  EXPECT_EQ(points.back(), Eigen::Vector2d(7.3, 3.1));
}

// Work, not seconds: sanitizers and busy machines must not fail it.
TEST(Search, ExpandsNoCellTwiceAndFewerThanWithoutTheGoalInView) {
  Random random(9);
  const CostMap map = MakeCostMap(Building(random, 300, 100), RobotOptions{}, 1);
  Eigen::Vector2i start(150, 150);
  while (!map.IsFree(start)) ++start.x();
  const auto costs = Dijkstra(map, start);
  std::size_t num_informed = 0;
  std::size_t num_uninformed = 0;
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector2i goal = RandomFreeCell(random, map);
    const auto cost_of_goal = costs.find(map.Index(goal));
    if (cost_of_goal == costs.end()) continue;
    const auto is_nearer = [&](const auto& cell) { return cell.second < cost_of_goal->second; };
    const SearchResult result = FindPath(map, start, goal);
    ASSERT_TRUE(result.found);
    EXPECT_LE(result.num_expanded, costs.size());
    num_informed += result.num_expanded;
    num_uninformed += static_cast<std::size_t>(std::ranges::count_if(costs, is_nearer));
  }
  EXPECT_GT(num_uninformed, 100000U);
  EXPECT_LT(num_informed, num_uninformed / 2);
}

}  // namespace
}  // namespace nightmap
