// SPDX-License-Identifier: Apache-2.0
// Slow and plain searches that tests and benchmarks of the plan stage compare with.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <numeric>
#include <queue>
#include <utility>
#include <vector>

#include "stages/plan/plan/cost_map.h"
#include "stages/plan/plan/segment.h"
#include "stages/plan/plan/theta_star.h"

namespace nightmap {

using Points = std::vector<Eigen::Vector2d>;

inline Eigen::Vector2d Centre(const Eigen::Vector2i& cell) {
  return cell.cast<double>() + Eigen::Vector2d(0.5, 0.5);
}

inline Points Centres(const std::vector<Eigen::Vector2i>& cells) {
  Points points;
  for (const auto& cell : cells) points.push_back(Centre(cell));
  return points;
}

// In cells.
inline double LengthOf(const Points& points) {
  double length = 0;
  for (std::size_t i = 1; i < points.size(); ++i) length += (points[i] - points[i - 1]).norm();
  return length;
}

// Infinite if a line touches a cell that is not free.
inline double CostOf(const CostMap& map, const Points& points) {
  double cost = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    cost += SegmentCost(map, points[i - 1], points[i]);
  }
  return cost;
}

// Costs as integers: a step costs its length times the sum of its two cells' costs.
struct SearchCost {
  static constexpr std::int64_t kStraight = 65536;  // length of one cell
  static constexpr std::int64_t kDiagonal = 92682;  // sqrt(2) * kStraight

  // Cost of one cell in free space far from obstacles is 1.
  static double InCells(std::int64_t cost) {
    return static_cast<double>(cost) / static_cast<double>(kStraight * 2 * CostMap::kUnitCost);
  }
};

// Dijkstra's algorithm with a heap: the cost from `source` to each cell by steps to the eight
// around it, as of kCellToCell; -1 where there is no way.
inline std::vector<std::int64_t> DijkstraCosts(const CostMap& map, const Eigen::Vector2i& source) {
  using Open = std::pair<std::int64_t, std::size_t>;
  std::vector<std::int64_t> costs(map.Size(), -1);
  std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
  open.emplace(0, map.Index(source));
  while (!open.empty()) {
    const auto [cost, index] = open.top();
    open.pop();
    if (costs[index] >= 0) continue;
    costs[index] = cost;
    const Eigen::Vector2i cell = map.Cell(index);
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const Eigen::Vector2i next(cell.x() + dx, cell.y() + dy);
        if (!map.IsFree(next) || !map.IsFree({next.x(), cell.y()}) ||
            !map.IsFree({cell.x(), next.y()}) || costs[map.Index(next)] >= 0) {
          continue;
        }
        const auto length = dx != 0 && dy != 0 ? SearchCost::kDiagonal : SearchCost::kStraight;
        open.emplace(cost + length * (map.costs[index] + map.costs[map.Index(next)]),
                     map.Index(next));
      }
    }
  }
  return costs;
}

// The cheapest path of straight lines that go up to 5 cells sideways and up, in 80 directions:
// apart from corners at most 0.5 % more expensive than the cheapest in any direction. A* with the
// costs of DijkstraCosts, which are at most 1 / cos(22.5 deg) times those in any direction. There
// must be a path from `start` to the cell that `to_goal` was made for.
inline std::vector<Eigen::Vector2i> ManyDirectionsPath(const CostMap& map,
                                                       const Eigen::Vector2i& start,
                                                       const std::vector<std::int64_t>& to_goal) {
  constexpr int kReach = 5;
  constexpr double kBound = 0.92;
  constexpr double kFar = 1e300;
  struct State {
    double g = kFar;
    std::size_t parent = 0;
    bool closed = false;
  };
  std::vector<State> states(map.Size());
  using Open = std::pair<double, std::size_t>;
  std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
  const auto reach = [&](std::size_t index, std::size_t parent, double g) {
    if (states[index].closed || states[index].g <= g) return;
    states[index].g = g;
    states[index].parent = parent;
    open.emplace(g + kBound * SearchCost::InCells(to_goal[index]), index);
  };
  reach(map.Index(start), map.Index(start), 0);
  while (to_goal[open.top().second] != 0) {
    const std::size_t index = open.top().second;
    open.pop();
    if (std::exchange(states[index].closed, true)) continue;
    const Eigen::Vector2i cell = map.Cell(index);
    for (int dy = -kReach; dy <= kReach; ++dy) {
      for (int dx = -kReach; dx <= kReach; ++dx) {
        const Eigen::Vector2i next(cell.x() + dx, cell.y() + dy);
        if (std::gcd(dx, dy) != 1 || !map.IsFree(next)) continue;
        const State& state = states[map.Index(next)];
        const double left = state.closed ? 0 : state.g - states[index].g;
        if (left <= Eigen::Vector2d(dx, dy).norm()) continue;
        const double cost = SegmentCost(map, Centre(cell), Centre(next), left);
        if (cost < left) reach(map.Index(next), index, states[index].g + cost);
      }
    }
  }
  std::vector<Eigen::Vector2i> cells;
  std::size_t at = open.top().second;
  cells.push_back(map.Cell(at));
  for (; at != map.Index(start); cells.push_back(map.Cell(at))) at = states[at].parent;
  std::reverse(cells.begin(), cells.end());
  return cells;
}

}  // namespace nightmap
