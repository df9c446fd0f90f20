// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/map_uncertainty.h"

#include <cmath>
#include <utility>

#include "pipeline/base/median.h"

namespace nightmap {

Matrix6d MapCovariance(const LandmarkMap& map,
                       const std::vector<int>& landmarks,
                       const Rigid3& camera_from_map) {
  Matrix6d covariance = Matrix6d::Zero();
  if (landmarks.empty()) return covariance;
  std::vector<double> sigmas_m;
  std::vector<double> distances_m;
  for (const int landmark : landmarks) {
    const auto i = static_cast<std::size_t>(landmark);
    sigmas_m.push_back(map.position_sigmas_m[i]);
    distances_m.push_back((camera_from_map * map.positions_in_map[i]).norm());
  }
  const double sigma_m = Median(std::move(sigmas_m));
  const double turn_sigma_rad = sigma_m / Median(std::move(distances_m));
  covariance.diagonal().head<3>().setConstant(std::pow(turn_sigma_rad, 2));
  covariance.diagonal().tail<3>().setConstant(std::pow(sigma_m, 2));
  return covariance;
}

}  // namespace nightmap
