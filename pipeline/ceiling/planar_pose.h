// SPDX-License-Identifier: Apache-2.0
// Poses in the plane as vectors x, y (m), heading (rad), with derivatives.
#pragma once

#include <Eigen/Core>

#include "pipeline/geometry/rigid2.h"

namespace nightmap {

inline Eigen::Vector3d ToVector(const Rigid2& pose) {
  return {pose.translation.x(), pose.translation.y(), pose.heading_rad};
}

inline Rigid2 ToRigid2(const Eigen::Vector3d& pose) {
  return {WrapAngle_rad(pose.z()), pose.head<2>()};
}

struct ComposedPose {
  Eigen::Vector3d pose;  // its heading is not wrapped
  Eigen::Matrix3d by_first;
  Eigen::Matrix3d by_second;
};

// a_from_b * b_from_c.
inline ComposedPose Compose(const Eigen::Vector3d& first, const Eigen::Vector3d& second) {
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(first.z()).toRotationMatrix();
  const Eigen::Vector2d moved = turn * second.head<2>();
  ComposedPose result;
  result.pose << first.head<2>() + moved, first.z() + second.z();
  result.by_first = result.by_second = Eigen::Matrix3d::Identity();
  result.by_first.topRightCorner<2, 1>() = Eigen::Vector2d(-moved.y(), moved.x());
  result.by_second.topLeftCorner<2, 2>() = turn;
  return result;
}

// a_from_b of map_from_a, map_from_b.
inline ComposedPose Between(const Eigen::Vector3d& first, const Eigen::Vector3d& second) {
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(-first.z()).toRotationMatrix();
  const Eigen::Vector2d between = turn * (second - first).head<2>();
  ComposedPose result;
  result.pose << between, second.z() - first.z();
  result.by_first = -Eigen::Matrix3d::Identity();
  result.by_first.topLeftCorner<2, 2>() = -turn;
  result.by_first.topRightCorner<2, 1>() = Eigen::Vector2d(between.y(), -between.x());
  result.by_second = Eigen::Matrix3d::Identity();
  result.by_second.topLeftCorner<2, 2>() = turn;
  return result;
}

struct SeenPoint {
  Eigen::Vector3d point;
  Eigen::Matrix3d by_pose;
  Eigen::Matrix3d by_point;
};

// A point of the map in the frame of map_from_a.
inline SeenPoint PointFrom(const Eigen::Vector3d& pose, const Eigen::Vector3d& point) {
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(-pose.z()).toRotationMatrix();
  const Eigen::Vector2d seen = turn * (point - pose).head<2>();
  SeenPoint result;
  result.point << seen, point.z();
  result.by_pose.setZero();
  result.by_pose.topLeftCorner<2, 2>() = -turn;
  result.by_pose.topRightCorner<2, 1>() = Eigen::Vector2d(seen.y(), -seen.x());
  result.by_point = Eigen::Matrix3d::Identity();
  result.by_point.topLeftCorner<2, 2>() = turn;
  return result;
}

// Covariance of x, y, heading from sigmas along and across the heading, and of it.
inline Eigen::Matrix3d TurnedVariance(double heading_rad, const Eigen::Vector3d& sigma) {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(heading_rad).toRotationMatrix();
  return turn * sigma.cwiseAbs2().asDiagonal() * turn.transpose();
}

}  // namespace nightmap
