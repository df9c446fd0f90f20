// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "stages/dense/map_frame/find_map_frame.h"

namespace nightmap {

// A camera that looks along x, its image's down along -z, pitched down a little.
inline Rigid3 Looking(double x_m, double height_m, double pitch_rad) {
  Eigen::Matrix3d rotation;
  rotation.col(0) = -Eigen::Vector3d::UnitY();
  rotation.col(1) = -Eigen::Vector3d::UnitZ();
  rotation.col(2) = Eigen::Vector3d::UnitX();
  const Eigen::AngleAxisd pitch(-pitch_rad, Eigen::Vector3d::UnitX());
  return {Eigen::Quaterniond(rotation) * Eigen::Quaterniond(pitch), {x_m, 0, height_m}};
}

// Upright cameras whose mount nobody states.
inline UpInput Held(const std::vector<Rigid3>& cameras) {
  const Rigid3 camera_from_robot{{0.5, 0.5, -0.5, 0.5}, Eigen::Vector3d::Zero()};
  UpInput input;
  for (const Rigid3& camera : cameras)
    input.given_from_robots.push_back(camera * camera_from_robot);
  return input;
}

}  // namespace nightmap
