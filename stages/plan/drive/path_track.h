// SPDX-License-Identifier: Apache-2.0
// A path as a polyline, addressed by distance along it.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace nightmap {

class PathTrack {
 public:
  // At least one point; repeated points are fine.
  explicit PathTrack(const std::vector<Eigen::Vector2d>& points);

  double Length_m() const { return distances_m_.back(); }
  // Clamped to the ends.
  Eigen::Vector2d At(double distance_m) const;
  // Distance, between two given ones, at which the track is nearest to a point; the first one on
  // ties.
  double Nearest_m(const Eigen::Vector2d& point, double from_m, double to_m) const;

 private:
  std::size_t SegmentAt(double distance_m) const;

  std::vector<Eigen::Vector2d> points_;
  std::vector<double> distances_m_;  // distance along the track of each point
};

}  // namespace nightmap
