// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/search.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>

namespace nightmap {
namespace {

constexpr std::int64_t kUnreached = std::numeric_limits<std::int64_t>::max();

struct Step {
  int dx = 0, dy = 0;
  std::int64_t length = 0;
};

constexpr std::array<Step, 8> kSteps = {{{1, 0, SearchCost::kStraight},
                                         {0, 1, SearchCost::kStraight},
                                         {-1, 0, SearchCost::kStraight},
                                         {0, -1, SearchCost::kStraight},
                                         {1, 1, SearchCost::kDiagonal},
                                         {-1, 1, SearchCost::kDiagonal},
                                         {-1, -1, SearchCost::kDiagonal},
                                         {1, -1, SearchCost::kDiagonal}}};

struct Open {
  std::int64_t f = 0;
  std::int64_t g = 0;
  int x = 0, y = 0;

  // For std::push_heap, which keeps the largest on top: "worse than".
  bool operator<(const Open& other) const {
    if (f != other.f) return f > other.f;
    if (g != other.g) return g < other.g;
    return y != other.y ? y > other.y : x > other.x;
  }
};

class Search {
 public:
  Search(const CostMap& map, const Eigen::Vector2i& start, const Eigen::Vector2i& goal)
      : map_(map),
        start_(map.Index(start)),
        goal_(map.Index(goal)),
        goal_cell_(goal),
        costs_(map.Size(), kUnreached),
        steps_(map.Size(), 0) {
    nearest_bound_ = SearchCost::LowerBound(start, goal);
    result_.nearest_reached = start;
    Push(start_, start, 0);
  }

  SearchResult Run() {
    while (!heap_.empty()) {
      std::pop_heap(heap_.begin(), heap_.end());
      const Open open = heap_.back();
      heap_.pop_back();
      const Eigen::Vector2i cell(open.x, open.y);
      if (open.g != costs_[map_.Index(cell)]) continue;  // a cheaper way was found since
      ++result_.num_expanded;
      if (cell == goal_cell_) return Found();
      Expand(cell, open.g);
    }
    return result_;
  }

 private:
  void Push(std::size_t index, const Eigen::Vector2i& cell, std::int64_t cost) {
    costs_[index] = cost;
    const std::int64_t bound = SearchCost::LowerBound(cell, goal_cell_);
    if (bound < nearest_bound_) {
      nearest_bound_ = bound;
      result_.nearest_reached = cell;
    }
    heap_.push_back({cost + bound, cost, cell.x(), cell.y()});
    std::push_heap(heap_.begin(), heap_.end());
  }

  void Expand(const Eigen::Vector2i& cell, std::int64_t g) {
    const std::int64_t own_cost = map_.costs[map_.Index(cell)];
    for (std::size_t i = 0; i < kSteps.size(); ++i) {
      const Step& step = kSteps[i];
      const Eigen::Vector2i next = cell + Eigen::Vector2i(step.dx, step.dy);
      if (!map_.IsFree(next)) continue;
      const std::size_t index = map_.Index(next);
      const std::int64_t cost = g + step.length * (own_cost + map_.costs[index]);
      if (cost >= costs_[index] || CutsCorner(cell, step)) continue;
      steps_[index] = static_cast<std::uint8_t>(i);
      Push(index, next, cost);
    }
  }

  bool CutsCorner(const Eigen::Vector2i& cell, const Step& step) const {
    return step.dx != 0 && step.dy != 0 &&
           !(map_.IsFree(cell + Eigen::Vector2i(step.dx, 0)) &&
             map_.IsFree(cell + Eigen::Vector2i(0, step.dy)));
  }

  SearchResult Found() {
    result_.found = true;
    result_.cost = costs_[goal_];
    Eigen::Vector2i cell = goal_cell_;
    result_.cells.push_back(cell);
    while (map_.Index(cell) != start_) {
      const Step& step = kSteps[steps_[map_.Index(cell)]];
      cell -= Eigen::Vector2i(step.dx, step.dy);
      result_.cells.push_back(cell);
    }
    std::reverse(result_.cells.begin(), result_.cells.end());
    return result_;
  }

  const CostMap& map_;
  std::size_t start_;
  std::size_t goal_;
  Eigen::Vector2i goal_cell_;
  std::vector<std::int64_t> costs_;  // from the start; kUnreached before
  std::vector<std::uint8_t> steps_;  // index of the step that led here
  std::vector<Open> heap_;
  std::int64_t nearest_bound_ = 0;
  SearchResult result_;
};

}  // namespace

std::int64_t SearchCost::LowerBound(const Eigen::Vector2i& a, const Eigen::Vector2i& b) {
  const std::int64_t dx = std::abs(a.x() - b.x());
  const std::int64_t dy = std::abs(a.y() - b.y());
  const std::int64_t diagonal = std::min(dx, dy);
  const std::int64_t straight = std::max(dx, dy) - diagonal;
  return (diagonal * kDiagonal + straight * kStraight) * 2 * CostMap::kUnitCost;
}

SearchResult FindPath(const CostMap& map,
                      const Eigen::Vector2i& start,
                      const Eigen::Vector2i& goal) {
  return Search(map, start, goal).Run();
}

}  // namespace nightmap
