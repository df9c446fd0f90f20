// SPDX-License-Identifier: Apache-2.0
// Rigid transforms in the plane, of robots that drive on a floor.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "pipeline/geometry/rigid3.h"

namespace nightmap {

// The same angle in [-pi, pi].
inline double WrapAngle_rad(double angle_rad) {
  return std::remainder(angle_rad, 2 * std::numbers::pi);
}

// target_from_source: point_in_target = rotation by heading * point_in_source + translation.
struct Rigid2 {
  double heading_rad = 0;
  Eigen::Vector2d translation = Eigen::Vector2d::Zero();  // metres

  Rigid2 Inverse() const {
    return {-heading_rad, -(Eigen::Rotation2Dd(-heading_rad) * translation)};
  }
  Eigen::Vector2d operator*(const Eigen::Vector2d& point) const {
    return Eigen::Rotation2Dd(heading_rad) * point + translation;
  }
  Rigid2 operator*(const Rigid2& other) const {
    return {WrapAngle_rad(heading_rad + other.heading_rad), *this * other.translation};
  }
  // In the plane z = 0.
  Rigid3 ToRigid3() const {
    const Eigen::AngleAxisd turn(heading_rad, Eigen::Vector3d::UnitZ());
    return {Eigen::Quaterniond(turn), {translation.x(), translation.y(), 0}};
  }
};

}  // namespace nightmap
