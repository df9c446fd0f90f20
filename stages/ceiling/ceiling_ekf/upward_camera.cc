// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_ekf/upward_camera.h"

#include <Eigen/Geometry>
#include <cmath>

namespace nightmap {
namespace {

constexpr double kMinDepth_m = 0.05;

Eigen::Matrix3d TurnAboutUp(double angle_rad) {
  return Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

Eigen::Matrix3d TiltRotation(const Eigen::Vector2d& tilt_rad) {
  const double angle_rad = tilt_rad.norm();
  if (angle_rad < 1e-12) return Eigen::Matrix3d::Identity() + Skew({tilt_rad.x(), tilt_rad.y(), 0});
  const Eigen::Vector3d axis(tilt_rad.x() / angle_rad, tilt_rad.y() / angle_rad, 0);
  return Eigen::AngleAxisd(angle_rad, axis).toRotationMatrix();
}

// exp(tilt + d) = exp(tilt) exp(J d), to the second order of the tilt.
Matrix32d RightJacobian(const Eigen::Vector2d& tilt_rad) {
  const Eigen::Matrix3d w = Skew({tilt_rad.x(), tilt_rad.y(), 0});
  const Eigen::Matrix3d jacobian = Eigen::Matrix3d::Identity() - 0.5 * w + w * w / 6;
  return jacobian.leftCols<2>();
}

// Derivative of exp(angle about up) * v by the angle.
Eigen::Vector3d Perpendicular(const Eigen::Vector3d& v) { return {-v.y(), v.x(), 0}; }

}  // namespace

std::optional<UpwardCamera::Projection> UpwardCamera::Project(const Eigen::Vector3d& pose,
                                                              const Eigen::Vector2d& tilt_rad,
                                                              const Eigen::Vector3d& point) const {
  const Eigen::Matrix3d map_from_robot = TurnAboutUp(pose.z());
  const Eigen::Vector3d from_robot = point - Eigen::Vector3d(pose.x(), pose.y(), 0);
  const Eigen::Vector3d in_robot = map_from_robot.transpose() * from_robot;
  const Eigen::Matrix3d mounting = robot_from_camera_.rotation.toRotationMatrix();
  const Eigen::Matrix3d camera_from_robot = (mounting * TiltRotation(tilt_rad)).transpose();
  const Eigen::Vector3d in_camera = camera_from_robot * (in_robot - robot_from_camera_.translation);
  if (in_camera.z() < kMinDepth_m) return std::nullopt;

  Projection projection;
  const double x = in_camera.x() / in_camera.z();
  const double y = in_camera.y() / in_camera.z();
  projection.pixel = {camera_.fx * x + camera_.cx, camera_.fy * y + camera_.cy};
  projection.depth_m = in_camera.z();
  Matrix23d by_camera;
  by_camera << camera_.fx, 0, -camera_.fx * x, 0, camera_.fy, -camera_.fy * y;
  by_camera /= in_camera.z();
  const Matrix23d by_robot = by_camera * camera_from_robot;
  projection.by_point = by_robot * map_from_robot.transpose();
  projection.by_pose.leftCols<2>() = -projection.by_point.leftCols<2>();
  projection.by_pose.col(2) = -by_robot * Perpendicular(in_robot);
  projection.by_tilt = by_camera * Skew(in_camera) * RightJacobian(tilt_rad);
  return projection;
}

UpwardCamera::RayPoint UpwardCamera::PointAt(const Eigen::Vector3d& pose,
                                             const Eigen::Vector2d& tilt_rad,
                                             const Eigen::Vector2d& pixel,
                                             double depth_m) const {
  const Eigen::Matrix3d map_from_robot = TurnAboutUp(pose.z());
  const Eigen::Matrix3d map_from_camera =
      map_from_robot * robot_from_camera_.rotation.toRotationMatrix() * TiltRotation(tilt_rad);
  const Eigen::Vector3d bearing = camera_.BackProjectUndistorted(pixel, 1);
  const Eigen::Vector3d from_robot =
      map_from_robot * robot_from_camera_.translation + map_from_camera * bearing * depth_m;
  RayPoint ray;
  ray.point = from_robot + Eigen::Vector3d(pose.x(), pose.y(), 0);
  ray.by_pose << Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Perpendicular(from_robot);
  ray.by_tilt = -map_from_camera * Skew(bearing * depth_m) * RightJacobian(tilt_rad);
  ray.by_pixel << map_from_camera.col(0) * (depth_m / camera_.fx),
      map_from_camera.col(1) * (depth_m / camera_.fy);
  ray.by_depth = map_from_camera * bearing;
  return ray;
}

std::optional<double> UpwardCamera::Triangulate(const View& first,
                                                const View& second,
                                                double min_parallax_rad) const {
  const Eigen::Vector3d from_a = PointAt(first.pose, first.tilt_rad, first.pixel, 0).point;
  const Eigen::Vector3d from_b = PointAt(second.pose, second.tilt_rad, second.pixel, 0).point;
  const Eigen::Vector3d along_a =
      PointAt(first.pose, first.tilt_rad, first.pixel, 1).point - from_a;
  const Eigen::Vector3d along_b =
      PointAt(second.pose, second.tilt_rad, second.pixel, 1).point - from_b;
  const double sine = along_a.cross(along_b).norm() / (along_a.norm() * along_b.norm());
  if (!(sine > std::sin(min_parallax_rad))) return std::nullopt;
  // from_a + s along_a and from_b + t along_b are nearest to each other.
  Eigen::Matrix2d normal;
  normal << along_a.squaredNorm(), -along_a.dot(along_b), -along_a.dot(along_b),
      along_b.squaredNorm();
  const Eigen::Vector3d between = from_b - from_a;
  const Eigen::Vector2d depths =
      normal.inverse() * Eigen::Vector2d(along_a.dot(between), -along_b.dot(between));
  if (!(depths.minCoeff() > kMinDepth_m)) return std::nullopt;
  return depths[1];
}

}  // namespace nightmap
