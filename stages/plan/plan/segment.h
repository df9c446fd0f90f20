// SPDX-License-Identifier: Apache-2.0
// Straight lines over the cost map: the cells they touch and their cost.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "stages/plan/plan/cost_map.h"

namespace nightmap {

// Position along a segment (0 to 1) of its next crossing with a grid line of one axis.
class GridCrossing {
 public:
  GridCrossing(double from, double delta, int first_cell, int last_cell)
      : step(last_cell < first_cell ? -1 : 1), num_left_(std::abs(last_cell - first_cell)) {
    if (num_left_ == 0) return;
    next = ((step > 0 ? first_cell + 1 : first_cell) - from) / delta;
    spacing_ = std::abs(1 / delta);
  }
  void Advance() {
    --num_left_;
    next = num_left_ > 0 ? next + spacing_ : std::numeric_limits<double>::infinity();
  }

  int step;
  double next = std::numeric_limits<double>::infinity();

 private:
  int num_left_;  // crossings left
  double spacing_ = 0;
};

// Points are in cells: the centre of cell (x, y) is (x + 0.5, y + 0.5). Calls visit(cell, length in
// cells) for every cell that a segment touches, in order, and stops when visit returns false.
// Visits both cells beside a crossed corner with length 0 (Amanatides and Woo, A fast voxel
// traversal algorithm for ray tracing, 1987). Returns whether visit always returned true.
template <typename Visit>
bool VisitSegment(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Visit& visit) {
  constexpr double kCornerTolerance = 1e-9;  // share of the segment's length
  Eigen::Vector2i cell = from.array().floor().cast<int>();
  const Eigen::Vector2i last = to.array().floor().cast<int>();
  const Eigen::Vector2d delta = to - from;
  const double length = delta.norm();
  GridCrossing x(from.x(), delta.x(), cell.x(), last.x());
  GridCrossing y(from.y(), delta.y(), cell.y(), last.y());
  double position = 0;
  while (std::min(x.next, y.next) < std::numeric_limits<double>::infinity()) {
    const double next = std::min(x.next, y.next);
    if (!visit(cell, (next - position) * length)) return false;
    position = next;
    const bool cross_x = x.next <= next + kCornerTolerance;
    const bool cross_y = y.next <= next + kCornerTolerance;
    if (cross_x && cross_y &&
        !(visit(Eigen::Vector2i(cell.x() + x.step, cell.y()), 0.0) &&
          visit(Eigen::Vector2i(cell.x(), cell.y() + y.step), 0.0))) {
      return false;
    }
    if (cross_x) {
      cell.x() += x.step;
      x.Advance();
    }
    if (cross_y) {
      cell.y() += y.step;
      y.Advance();
    }
  }
  return visit(cell, (1 - position) * length);
}

// Whether a robot can drive straight from one point to the other. Both ends are on the map.
inline bool IsSegmentFree(const CostMap& map,
                          const Eigen::Vector2d& from,
                          const Eigen::Vector2d& to) {
  return VisitSegment(
      from, to, [&](const Eigen::Vector2i& cell, double) { return map.IsFree(cell); });
}

// Length of a segment in cells, weighted by the costs of the cells it touches. Infinite when one of
// them is not free, or once it exceeds `max_cost`. Both ends are on the map.
inline double SegmentCost(const CostMap& map,
                          const Eigen::Vector2d& from,
                          const Eigen::Vector2d& to,
                          double max_cost = std::numeric_limits<double>::infinity()) {
  const double limit = max_cost * CostMap::kUnitCost;
  double sum = 0;
  const bool free = VisitSegment(from, to, [&](const Eigen::Vector2i& cell, double length) {
    const int cost = map.costs[map.Index(cell)];
    sum += length * cost;
    return cost > 0 && sum <= limit;
  });
  return free ? sum / CostMap::kUnitCost : std::numeric_limits<double>::infinity();
}

}  // namespace nightmap
