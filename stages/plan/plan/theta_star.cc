// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/theta_star.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "stages/plan/plan/block_field.h"
#include "stages/plan/plan/bucket_queue.h"
#include "stages/plan/plan/cell_array.h"

namespace nightmap {
namespace {

constexpr double kKeysPerCell = 64;
constexpr int kKeyBits = 3;  // an eighth of a cell
constexpr std::int64_t kMaxRise = 1 << 16;
// Longer lines take longer to check, and pulling the path tight joins them anyway.
constexpr int kMaxLine_cells = 48;
// Half a diagonal step of A* is sqrt(0.5) cut to few bits, so that sums of costs are exact: the
// order in which they are added does not matter, and no cell is expanded again for a rounding
// error.
constexpr double kHalfDiagonal = 92682.0 / 131072;

// Cost in cells of the straight line between the centres of two free cells: its length weighted by
// the cells it touches. Infinite when one of them, or one beside a crossed corner, is not free, or
// once it exceeds `max_cost`. Equals SegmentCost, without branches on the axis.
double LineCost(const CostMap& map,
                const Eigen::Vector2i& from,
                const Eigen::Vector2i& to,
                double max_cost) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr double kCornerTolerance = 1e-9;
  const Eigen::Vector2i delta = to - from;
  const Eigen::Vector2i extent = delta.cwiseAbs();
  const std::ptrdiff_t step_x = delta.x() < 0 ? -1 : 1;
  const std::ptrdiff_t step_y = delta.y() < 0 ? -map.Stride() : map.Stride();
  const double spacing_x = extent.x() > 0 ? 1.0 / extent.x() : kInfinity;
  const double spacing_y = extent.y() > 0 ? 1.0 / extent.y() : kInfinity;
  const double length = delta.cast<double>().norm();
  const double limit = max_cost * CostMap::kUnitCost / length;
  const std::uint16_t* at = map.costs.data() + map.Index(from);
  const std::uint16_t* end = map.costs.data() + map.Index(to);
  double next_x = spacing_x / 2;
  double next_y = spacing_y / 2;
  double position = 0;
  double sum = 0;
  while (at != end) {
    const double next = std::min(next_x, next_y);
    const bool cross_x = next_x <= next + kCornerTolerance;
    const bool cross_y = next_y <= next + kCornerTolerance;
    if (cross_x && cross_y && (at[step_x] == 0 || at[step_y] == 0)) return kInfinity;
    sum += (next - position) * *at;
    position = next;
    at += (cross_x ? step_x : 0) + (cross_y ? step_y : 0);
    next_x += cross_x ? spacing_x : 0;
    next_y += cross_y ? spacing_y : 0;
    if (*at == 0 || sum > limit) return kInfinity;
  }
  return (sum + (1 - position) * *end) * length / CostMap::kUnitCost;
}

class ThetaStar {
 public:
  ThetaStar(const CostMap& map, const BlockField& field, const Eigen::Vector2i& goal, Steps steps)
      : map_(map),
        field_(field),
        goal_(goal),
        any_angle_(steps == Steps::kAnyAngle),
        half_diagonal_(any_angle_ ? std::sqrt(0.5) : kHalfDiagonal),
        open_squared_(SquaredFromRadius(map, 1)),
        wide_squared_(SquaredFromRadius(map, 2)),
        order_(map.width, map.height),
        states_(order_.Size()),
        queue_(kKeyBits, kMaxRise) {}

  SearchResult Run(const Eigen::Vector2i& start) {
    SearchResult result;
    Reach(start, order_.Index(start), 0);
    while (!IsDone()) {
      const Eigen::Vector2i cell = queue_.Pop();
      State& state = states_[order_.Index(cell)];
      if (state.closed != 0) continue;
      state.closed = 1;
      ++result.num_expanded;
      if (any_angle_) StraightenTo(cell, state);
      if (cell != goal_) Expand(cell, state);
    }
    return Found(std::move(result));
  }

 private:
  static std::int32_t SquaredFromRadius(const CostMap& map, int num_diagonals) {
    const double cells = map.robot_radius_m / map.resolution_m + num_diagonals * std::sqrt(2.0);
    return static_cast<std::int32_t>(std::ceil(std::min(cells * cells + 1e-6, 2e9)));
  }

  struct State {
    double g_plus_1;  // 0: not reached
    std::uint32_t parent;
    std::uint32_t closed;
  };

  // Octile distance, the least possible cost.
  double StepsToGoal(const Eigen::Vector2i& cell) const {
    const Eigen::Vector2i way = (goal_ - cell).cwiseAbs();
    return way.maxCoeff() + (2 * kHalfDiagonal - 1) * way.minCoeff();
  }

  void Reach(const Eigen::Vector2i& cell, std::size_t parent, double g) {
    State& state = states_[order_.Index(cell)];
    if (state.g_plus_1 != 0 && state.g_plus_1 <= g + 1) return;
    if (any_angle_ && state.closed != 0) return;
    state = {g + 1, static_cast<std::uint32_t>(parent), 0};
    const double f = g + (any_angle_ ? field_.CostToGoal(cell) : StepsToGoal(cell));
    queue_.Push(static_cast<std::int64_t>(f * kKeysPerCell), cell);
  }

  // The cheapest path from cell to cell is found once no remaining entry can be cheaper: cells that
  // leave the queue early, because the order within a bucket is not that of F, may be expanded
  // again.
  bool IsDone() {
    if (queue_.IsEmpty()) return true;
    const State& goal = states_[order_.Index(goal_)];
    if (any_angle_ || goal.g_plus_1 == 0) return goal.closed != 0;
    return static_cast<double>(queue_.MinKey()) >= kKeysPerCell * (goal.g_plus_1 - 1);
  }

  // The lazy part of Lazy Theta*: a cell was reached from an adjacent one. When it is expanded, it
  // is joined by a straight line to that cell's parent if that costs no more.
  void StraightenTo(const Eigen::Vector2i& cell, State& state) {
    const std::size_t grandparent = states_[state.parent].parent;
    if (grandparent == state.parent) return;
    const Eigen::Vector2i from = order_.Cell(grandparent);
    if ((from - cell).cwiseAbs().maxCoeff() > kMaxLine_cells) return;
    const double g = states_[grandparent].g_plus_1;
    const double cost = LineCost(map_, from, cell, state.g_plus_1 - g);
    if (g + cost > state.g_plus_1) return;
    state.g_plus_1 = g + cost;
    state.parent = static_cast<std::uint32_t>(grandparent);
  }

  // Distance of a cell from the border.
  int ToBorder(const Eigen::Vector2i& cell) const {
    const Eigen::Vector2i last(map_.width - 1, map_.height - 1);
    return cell.cwiseMin(last - cell).minCoeff();
  }
  static bool IsEven(const Eigen::Vector2i& cell) { return ((cell.x() | cell.y()) & 1) == 0; }

  // In open space only cells with two even coordinates are vertices of Lazy Theta*. Near obstacles
  // and at the border all cells are, so that no passage is missed. Every reached cell except the
  // start is a vertex.
  bool IsVertex(const Eigen::Vector2i& cell) const {
    return !any_angle_ || IsEven(cell) || states_[order_.Index(cell)].g_plus_1 > 1 ||
           cell == goal_ || ToBorder(cell) == 0 ||
           map_.distances.Squared(cell, open_squared_) < open_squared_;
  }

  void Expand(const Eigen::Vector2i& cell, const State& state) {
    constexpr std::array<std::array<int, 2>, 8> kSteps = {
        {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, 1}, {1, -1}, {-1, -1}}};
    const std::size_t index = order_.Index(cell);
    const bool is_even = IsEven(cell);
    const bool only_even = any_angle_ && is_even &&
                           map_.distances.Squared(cell, wide_squared_) >= wide_squared_ &&
                           ToBorder(cell) > 1 && (cell - goal_).cwiseAbs().maxCoeff() > 1;
    const double g = state.g_plus_1 - 1;
    for (const auto& [dx, dy] : kSteps) {
      const Eigen::Vector2i step(dx, dy);
      const double cost = StepCost(cell, step);
      if (cost < 0) continue;
      if (!only_even && IsVertex(cell + step)) {
        Reach(cell + step, index, g + cost);
      } else if (const double onwards = is_even ? StepCost(cell + step, step) : -1; onwards > 0) {
        Reach(cell + 2 * step, index, g + cost + onwards);
      }
    }
  }

  // Cost in cells of a step to one of the eight neighbours of a free cell; -1 when that is not free
  // or the step cuts a corner.
  double StepCost(const Eigen::Vector2i& cell, const Eigen::Vector2i& step) const {
    const std::uint16_t* cost = map_.costs.data() + map_.Index(cell);
    const std::ptrdiff_t up = step.y() * std::ptrdiff_t{map_.Stride()};
    if (cost[step.x()] == 0 || cost[up] == 0 || cost[step.x() + up] == 0) return -1;
    const double half_length = step.x() != 0 && step.y() != 0 ? half_diagonal_ : 0.5;
    return half_length * (*cost + cost[step.x() + up]) / CostMap::kUnitCost;
  }

  SearchResult Found(SearchResult result) const {
    std::size_t at = order_.Index(goal_);
    if (states_[at].g_plus_1 == 0) return result;
    result.found = true;
    result.cost_cells = states_[at].g_plus_1 - 1;
    result.cells.push_back(goal_);
    while (states_[at].parent != at) {
      at = states_[at].parent;
      result.cells.push_back(order_.Cell(at));
    }
    std::reverse(result.cells.begin(), result.cells.end());
    return result;
  }

  const CostMap& map_;
  const BlockField& field_;
  Eigen::Vector2i goal_;
  bool any_angle_;
  double half_diagonal_;
  // From this squared distance on, all eight neighbours of a cell are free,
  std::int32_t open_squared_;
  std::int32_t wide_squared_;  // and from this one on, so are their neighbours
  SquareOrder order_;
  CellArray<State> states_;
  BucketQueue<Eigen::Vector2i> queue_;
};

}  // namespace

SearchResult FindPath(const CostMap& map,
                      const Eigen::Vector2i& start,
                      const Eigen::Vector2i& goal,
                      Steps steps) {
  const BlockField field(map, goal);
  if (!field.Reaches(start)) return {};
  return ThetaStar(map, field, goal, steps).Run(start);
}

}  // namespace nightmap
