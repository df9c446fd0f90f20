// SPDX-License-Identifier: Apache-2.0
// A path as a line to be followed, by its length.
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
  // Where between two distances the track comes nearest to a point; the first such place.
  double Nearest_m(const Eigen::Vector2d& point, double from_m, double to_m) const;

 private:
  std::size_t SegmentAt(double distance_m) const;

  std::vector<Eigen::Vector2d> points_;
  std::vector<double> distances_m_;  // of each point, along the track
};

}  // namespace nightmap
