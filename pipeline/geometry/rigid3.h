// SPDX-License-Identifier: Apache-2.0
// Rigid transforms between frames of reference.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

namespace nightmap {

// target_from_source: point_in_target = rotation * point_in_source + translation (metres).
// Composition reads like the names: a_from_c = a_from_b * b_from_c.
struct Rigid3 {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Rigid3 Inverse() const {
    const Eigen::Quaterniond inverse = rotation.conjugate();
    return {inverse, -(inverse * translation)};
  }
  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const {
    return rotation * point + translation;
  }
  Rigid3 operator*(const Rigid3& other) const {
    return {(rotation * other.rotation).normalized(), rotation * other.translation + translation};
  }
  Eigen::Matrix4d Matrix() const {
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    matrix.topLeftCorner<3, 3>() = rotation.toRotationMatrix();
    matrix.topRightCorner<3, 1>() = translation;
    return matrix;
  }
};

// The matrix of the cross product: Skew(a) * b = a x b.
inline Eigen::Matrix3d Skew(const Eigen::Vector3d& a) {
  Eigen::Matrix3d matrix;
  matrix << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return matrix;
}

// Left perturbation of a pose: rotation (rad) first, then translation (m); covariances likewise.
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

// The pose after a left perturbation (rotation rad, translation m): a rotation about the target's
// origin, then a shift.
inline Rigid3 PerturbLeft(const Vector6d& step, const Rigid3& pose) {
  const Eigen::Vector3d axis = step.head<3>();
  const double angle = axis.norm();
  const Eigen::Quaterniond rotation =
      angle < 1e-12 ? Eigen::Quaterniond::Identity()
                    : Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis / angle));
  return Rigid3{rotation, step.tail<3>()} * pose;
}

// Angle of the rotation between two poses, in [0, pi].
inline double AngleBetween_rad(const Rigid3& a, const Rigid3& b) {
  return a.rotation.angularDistance(b.rotation);
}

// Pose of a frame at a time, as in TUM files.
struct StampedPose {
  std::int64_t time_ns = 0;
  Rigid3 pose;
};

// Maps a left perturbation (rotation, translation) in the source frame to the target frame: pose *
// exp(x) = exp(Adjoint(pose) x) * pose.
inline Matrix6d Adjoint(const Rigid3& pose) {
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  Matrix6d adjoint = Matrix6d::Zero();
  adjoint.topLeftCorner<3, 3>() = rotation;
  adjoint.bottomRightCorner<3, 3>() = rotation;
  adjoint.bottomLeftCorner<3, 3>() = Skew(pose.translation) * rotation;
  return adjoint;
}

}  // namespace nightmap
