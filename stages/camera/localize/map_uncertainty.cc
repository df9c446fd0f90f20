// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/map_uncertainty.h"

#include <cmath>
#include <utility>

#include "pipeline/base/median.h"

namespace nightmap {

Matrix6d MapCovariance(const Place& place) {
  Matrix6d covariance = Matrix6d::Zero();
  if (place.pose.inliers.empty()) return covariance;
  std::vector<double> sigmas_m;
  std::vector<double> distances_m;
  for (const int inlier : place.pose.inliers) {
    const auto i = static_cast<std::size_t>(inlier);
    sigmas_m.push_back(place.position_sigmas_m[i]);
    distances_m.push_back((place.pose.camera_from_world * place.points[i].point_in_world).norm());
  }
  const double sigma_m = Median(std::move(sigmas_m));
  const double turn_sigma_rad = sigma_m / Median(std::move(distances_m));
  covariance.diagonal().head<3>().setConstant(std::pow(turn_sigma_rad, 2));
  covariance.diagonal().tail<3>().setConstant(std::pow(sigma_m, 2));
  return covariance;
}

}  // namespace nightmap
