// SPDX-License-Identifier: Apache-2.0
// How high the ceiling is, by the landmarks on it.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace nightmap {

// Heights in cells of 0.1 m: the median of the landmarks within `radius_m`, where there are three
// at least; elsewhere the median of all.
class CeilingHeights {
 public:
  // `low` and `high`: corners (m) of the area. At least one point.
  CeilingHeights(const std::vector<Eigen::Vector3d>& points,
                 double radius_m,
                 const Eigen::Vector2d& low,
                 const Eigen::Vector2d& high);

  // The height of the nearest cell, also outside of the area.
  double At_m(const Eigen::Vector2d& place) const;

 private:
  Eigen::Vector2d low_;
  Eigen::Index width_ = 0, height_ = 0;  // cells
  std::vector<double> heights_m_;        // row by row
};

}  // namespace nightmap
