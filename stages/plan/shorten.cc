// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/shorten.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace nightmap {
namespace {

constexpr double kCornerTolerance = 1e-9;  // of the segment's length
constexpr double kCostTolerance = 1e-6;    // cells
// How many points in a row may fail before the search for a longer shortcut ends.
constexpr int kMaxFailures = 32;

Eigen::Vector2i CellAt(const Eigen::Vector2d& point) {
  return {static_cast<int>(std::floor(point.x())), static_cast<int>(std::floor(point.y()))};
}

// Position along a segment (0 to 1) of its next crossing of a grid line of one axis.
struct Axis {
  Axis(double from, double delta, int first_cell, int last_cell)
      : step(last_cell < first_cell ? -1 : 1), num_left(std::abs(last_cell - first_cell)) {
    if (num_left == 0) return;
    next = ((step > 0 ? first_cell + 1 : first_cell) - from) / delta;
    spacing = std::abs(1 / delta);
  }
  void Advance() {
    --num_left;
    next = num_left > 0 ? next + spacing : std::numeric_limits<double>::infinity();
  }

  int step;
  int num_left;  // crossings to come
  double next = std::numeric_limits<double>::infinity();
  double spacing = 0;
};

// Cost of a free segment in cells; infinite when it is not free.
double SegmentCost(const CostMap& map, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  double cost = 0;
  const bool free = VisitSegment(from, to, [&](const Eigen::Vector2i& cell, double length) {
    if (!map.IsFree(cell)) return false;
    cost += length * map.costs[map.Index(cell)] / CostMap::kUnitCost;
    return true;
  });
  return free ? cost : std::numeric_limits<double>::infinity();
}

}  // namespace

bool VisitSegment(const Eigen::Vector2d& from,
                  const Eigen::Vector2d& to,
                  const std::function<bool(const Eigen::Vector2i&, double)>& visit) {
  Eigen::Vector2i cell = CellAt(from);
  const Eigen::Vector2i last = CellAt(to);
  const Eigen::Vector2d delta = to - from;
  Axis x(from.x(), delta.x(), cell.x(), last.x());
  Axis y(from.y(), delta.y(), cell.y(), last.y());
  double position = 0;
  while (x.num_left > 0 || y.num_left > 0) {
    const double next = std::min(x.next, y.next);
    if (!visit(cell, (next - position) * delta.norm())) return false;
    position = next;
    const bool cross_x = x.next <= next + kCornerTolerance;
    const bool cross_y = y.next <= next + kCornerTolerance;
    const Eigen::Vector2i beside_x(cell.x() + x.step, cell.y());
    const Eigen::Vector2i beside_y(cell.x(), cell.y() + y.step);
    if (cross_x && cross_y && !(visit(beside_x, 0) && visit(beside_y, 0))) return false;
    if (cross_x) {
      cell.x() += x.step;
      x.Advance();
    }
    if (cross_y) {
      cell.y() += y.step;
      y.Advance();
    }
  }
  return visit(cell, (1 - position) * delta.norm());
}

bool IsSegmentFree(const CostMap& map, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
  return VisitSegment(
      from, to, [&](const Eigen::Vector2i& cell, double) { return map.IsFree(cell); });
}

std::vector<Eigen::Vector2d> Shorten(const CostMap& map, const std::vector<Eigen::Vector2d>& path) {
  std::vector<Eigen::Vector2d> tight = {path.front()};
  std::size_t anchor = 0;
  while (anchor + 1 < path.size()) {
    std::size_t best = anchor + 1;
    double cost_along = SegmentCost(map, path[anchor], path[best]);
    int num_failures = 0;
    for (std::size_t i = best + 1; i < path.size() && num_failures < kMaxFailures; ++i) {
      cost_along += SegmentCost(map, path[i - 1], path[i]);
      if (SegmentCost(map, path[anchor], path[i]) <= cost_along + kCostTolerance) {
        best = i;
        num_failures = 0;
      } else {
        ++num_failures;
      }
    }
    anchor = best;
    tight.push_back(path[anchor]);
  }
  return tight;
}

std::vector<Eigen::Vector2d> Resample(const std::vector<Eigen::Vector2d>& path) {
  std::vector<Eigen::Vector2d> points = {path.front()};
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Eigen::Vector2d delta = path[i] - path[i - 1];
    const int num_parts = std::max(1, static_cast<int>(std::ceil(delta.norm() - 1e-9)));
    for (int k = 1; k < num_parts; ++k) {
      points.push_back(path[i - 1] + delta * k / num_parts);
    }
    points.push_back(path[i]);
  }
  return points;
}

}  // namespace nightmap
