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

// Covariance of a left perturbation (three rotations, then three translations) of a robot that
// drives in the plane z = 0, from that of x, y and heading. The floor holds it within these sigmas.
inline Matrix6d OnFloor(const Eigen::Matrix3d& planar,
                        double plane_sigma_m = 0.005,
                        double plane_sigma_rad = 0.01) {
  constexpr int kRows[] = {3, 4, 2};
  Vector6d sigma;
  sigma << plane_sigma_rad, plane_sigma_rad, 0, 0, 0, plane_sigma_m;
  Matrix6d covariance = sigma.cwiseAbs2().asDiagonal();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) covariance(kRows[i], kRows[j]) = planar(i, j);
  }
  return covariance;
}

// Keeps of a pose what moves in the plane z = 0: the turn about z, and x and y.
inline Rigid2 ToRigid2(const Rigid3& pose) {
  return {WrapAngle_rad(2 * std::atan2(pose.rotation.z(), pose.rotation.w())),
          pose.translation.head<2>()};
}

}  // namespace nightmap
