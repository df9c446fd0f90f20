// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "pipeline/geometry/rigid3.h"

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

}  // namespace nightmap
