// SPDX-License-Identifier: Apache-2.0
// The keyscans of a drive, and how far the robot may have drifted between two of them.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/geometry/rigid2.h"
#include "pipeline/io/edges_io.h"

namespace nightmap {

struct Keyscan {
  std::int64_t time_ns = 0;
  Rigid2 start_from_robot;                        // by scan matching
  double path_m = 0;                              // driven since the first keyscan
  std::vector<Eigen::Vector2d> points_in_robot;   // hits, thinned
  std::vector<Eigen::Vector2d> normals_in_robot;  // of their walls (wall_normals.h)
};

// The uncertainty of a keyscan's pose as another one sees it: x, y along the start's axes, heading.
struct Drift {
  Eigen::Matrix2d covariance_m2 = Eigen::Matrix2d::Zero();
  double variance_rad2 = 0;
  double lost_rad2 = 0;  // its part from motions that no scan tells

  double Sigma_m() const { return std::sqrt(covariance_m2.trace()); }
  double Sigma_rad() const { return std::sqrt(variance_rad2); }
  // The robot was carried, or switched on elsewhere: scan_match begins a part of its own.
  // The sum of a long way is known, however large: it asks for no search of all submaps.
  bool IsUnknown() const { return lost_rad2 > 1; }
};

// Adds up the covariances of the motions between consecutive keyscans. An error of a heading turns
// all that comes after it. Sums from the first keyscan on make a drift take constant time.
class DriftSums {
 public:
  // edges[i] leads from keyscan i to i + 1.
  DriftSums(const std::vector<Keyscan>& keyscans, const std::vector<SensorEdge>& edges);

  // The uncertainty of the position and heading of keyscan b, seen from keyscan a < b.
  Drift Between(std::size_t a, std::size_t b) const;

 private:
  struct Sums {
    Eigen::Matrix2d covariance_m2 = Eigen::Matrix2d::Zero();
    double variance_rad2 = 0;
    double lost_rad2 = 0;
    Eigen::Vector2d moment = Eigen::Vector2d::Zero();         // of the variances at their places
    Eigen::Matrix2d second_moment = Eigen::Matrix2d::Zero();  // likewise
  };

  std::vector<Eigen::Vector2d> places_;
  std::vector<Sums> sums_;  // of the edges before each keyscan
};

}  // namespace nightmap
