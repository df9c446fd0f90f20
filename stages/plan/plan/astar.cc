// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/astar.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>

#include "pipeline/base/error.h"
#include "stages/plan/plan/bucket_queue.h"
#include "stages/plan/plan/cell_array.h"

namespace nightmap {
namespace {

constexpr int kBucketShift = 23;  // a sixteenth of a straight step between cells of unit cost

// The cost G of a cell counts down from here, so that zero, the value of untouched memory, means
// not reached.
constexpr std::int64_t kUnreached = std::numeric_limits<std::int64_t>::max();

struct Open {
  std::int64_t g = 0;
  int x = 0, y = 0;  // with the rim
};

// Cells that leave the queue early may be expanded again, because the order within a bucket is not
// that of F. The path is still the cheapest, since the search ends only when no remaining entry can
// be cheaper.
class AStar {
 public:
  AStar(const CostMap& map, const Eigen::Vector2i& start, const Eigen::Vector2i& goal)
      : stride_(map.Stride()),
        costs_(map.costs.data()),
        goal_x_(goal.x() + 1),
        goal_y_(goal.y() + 1),
        start_(map.Index(start)),
        goal_(map.Index(goal)),
        g_below_(map.Size()),
        queue_(kBucketShift, MaxRise(map)) {
    Reach(start_, start.x() + 1, start.y() + 1, 0);
  }

  SearchResult Run(const CostMap& map) {
    SearchResult result;
    while (!queue_.IsEmpty() && queue_.MinKey() < G(goal_)) {
      const Open open = queue_.Pop();
      const std::size_t index = IndexOf(open.x, open.y);
      if (open.g != G(index) || open.g + Bound(open.x, open.y) >= G(goal_)) continue;
      ++result.num_expanded;
      Expand(index, open);
    }
    result.found = g_below_[goal_] != 0;
    if (result.found) {
      result.cost_cells = SearchCost::InCells(G(goal_));
      Trace(map, result.cells);
    }
    return result;
  }

 private:
  // F rises by at most twice the most expensive step.
  static std::int64_t MaxRise(const CostMap& map) {
    const std::int64_t max_cost = *std::max_element(map.costs.begin(), map.costs.end());
    return 4 * SearchCost::kDiagonal * max_cost;
  }

  std::size_t IndexOf(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(stride_) +
           static_cast<std::size_t>(x);
  }
  std::int64_t G(std::size_t index) const { return kUnreached - g_below_[index]; }
  std::int64_t Bound(int x, int y) const {
    return SearchCost::LowerBound({x, y}, {goal_x_, goal_y_});
  }

  void Reach(std::size_t index, int x, int y, std::int64_t g) {
    if (kUnreached - g <= g_below_[index]) return;
    g_below_[index] = kUnreached - g;
    queue_.Push(g + Bound(x, y), {g, x, y});
  }

  void Expand(std::size_t index, const Open& open) {
    const std::uint16_t* cell = costs_ + index;
    const std::int64_t own = *cell;
    const auto step = [&](int dx, int dy, std::int64_t length) {
      const std::ptrdiff_t offset = std::ptrdiff_t{dy} * stride_ + dx;
      Reach(index + static_cast<std::size_t>(offset),
            open.x + dx,
            open.y + dy,
            open.g + length * (own + cell[offset]));
    };
    const bool right = cell[1] != 0;
    const bool left = cell[-1] != 0;
    const bool up = cell[stride_] != 0;
    const bool down = cell[-stride_] != 0;
    if (right) step(1, 0, SearchCost::kStraight);
    if (left) step(-1, 0, SearchCost::kStraight);
    if (up) step(0, 1, SearchCost::kStraight);
    if (down) step(0, -1, SearchCost::kStraight);
    if (right && up && cell[stride_ + 1] != 0) step(1, 1, SearchCost::kDiagonal);
    if (left && up && cell[stride_ - 1] != 0) step(-1, 1, SearchCost::kDiagonal);
    if (right && down && cell[1 - stride_] != 0) step(1, -1, SearchCost::kDiagonal);
    if (left && down && cell[-1 - stride_] != 0) step(-1, -1, SearchCost::kDiagonal);
  }

  // Traces back from the goal over cells whose G and step add up; ties: the first in order.
  void Trace(const CostMap& map, std::vector<Eigen::Vector2i>& cells) const {
    std::size_t at = goal_;
    cells.push_back(map.Cell(at));
    while (at != start_) {
      at = Before(at);
      cells.push_back(map.Cell(at));
    }
    std::reverse(cells.begin(), cells.end());
  }

  std::size_t Before(std::size_t index) const {
    const std::array<std::ptrdiff_t, 4> sides = {1, -1, stride_, -stride_};
    const auto leads_here = [&](std::ptrdiff_t offset, std::int64_t length) {
      const std::size_t from = index + static_cast<std::size_t>(offset);
      return g_below_[from] != 0 && G(from) + length * (costs_[from] + costs_[index]) == G(index);
    };
    for (const std::ptrdiff_t side : sides) {
      if (leads_here(side, SearchCost::kStraight)) return index + static_cast<std::size_t>(side);
    }
    for (const int i : {0, 1}) {
      for (const int j : {2, 3}) {
        const std::ptrdiff_t x = sides[static_cast<std::size_t>(i)];
        const std::ptrdiff_t y = sides[static_cast<std::size_t>(j)];
        const bool cuts_corner = costs_[index + static_cast<std::size_t>(x)] == 0 ||
                                 costs_[index + static_cast<std::size_t>(y)] == 0;
        if (!cuts_corner && leads_here(x + y, SearchCost::kDiagonal)) {
          return index + static_cast<std::size_t>(x + y);
        }
      }
    }
    throw DataError("the search lost its way back to the start: report this bug");
  }

  std::ptrdiff_t stride_;
  const std::uint16_t* costs_;
  int goal_x_, goal_y_;
  std::size_t start_, goal_;
  CellArray<std::int64_t> g_below_;
  BucketQueue<Open> queue_;
};

}  // namespace

std::int64_t SearchCost::LowerBound(const Eigen::Vector2i& a, const Eigen::Vector2i& b) {
  const std::int64_t dx = std::abs(a.x() - b.x());
  const std::int64_t dy = std::abs(a.y() - b.y());
  return (std::max(dx, dy) * kStraight + std::min(dx, dy) * (kDiagonal - kStraight)) * 2 *
         CostMap::kUnitCost;
}

SearchResult FindPath(const CostMap& map,
                      const Eigen::Vector2i& start,
                      const Eigen::Vector2i& goal) {
  return AStar(map, start, goal).Run(map);
}

}  // namespace nightmap
