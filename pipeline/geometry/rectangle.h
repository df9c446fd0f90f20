// SPDX-License-Identifier: Apache-2.0
// Axis-aligned rectangles of the map, seen from above.
#pragma once

#include <Eigen/Core>
#include <limits>

namespace nightmap {

// min_m <= (x, y) < max_m; unbounded until bounds are given.
struct Rectangle {
  static constexpr double kUnbounded = std::numeric_limits<double>::infinity();
  Eigen::Vector2d min_m = Eigen::Vector2d::Constant(-kUnbounded);
  Eigen::Vector2d max_m = Eigen::Vector2d::Constant(kUnbounded);

  bool Contains(const Eigen::Vector2d& point) const {
    return (point.array() >= min_m.array()).all() && (point.array() < max_m.array()).all();
  }
  // Whether a closed rectangle intersects this one.
  bool Touches(const Eigen::Vector2d& other_min_m, const Eigen::Vector2d& other_max_m) const {
    return (other_max_m.array() >= min_m.array()).all() &&
           (other_min_m.array() < max_m.array()).all();
  }
  bool IsBounded() const { return min_m.allFinite() && max_m.allFinite(); }
  Rectangle Grown(double by_m) const { return {min_m.array() - by_m, max_m.array() + by_m}; }
};

}  // namespace nightmap
