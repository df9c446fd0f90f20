// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_ekf/disparity_depth.h"

namespace nightmap {
namespace {

constexpr double kNearest_m = 0.05;
constexpr double kMinDisparity_rad = 1e-6;  // what rounding makes of none is less

// Where a level camera is in x and y, and where it sees a pixel per metre of height.
struct LevelRay {
  Eigen::Vector2d from, along;
  double rise = 0;  // height per metre of depth
  Matrix23d from_by_pose, along_by_pose;
  Eigen::Matrix2d along_by_tilt, along_by_pixel;
  Eigen::RowVector2d rise_by_tilt, rise_by_pixel;
};

LevelRay LevelRayAt(const UpwardCamera& camera,
                    const Eigen::Vector3d& pose,
                    const Eigen::Vector2d& pixel) {
  const UpwardCamera::RayPoint start = camera.PointAt(pose, Eigen::Vector2d::Zero(), pixel, 0);
  const UpwardCamera::RayPoint end = camera.PointAt(pose, Eigen::Vector2d::Zero(), pixel, 1);
  const Eigen::Vector3d along = end.point - start.point;
  LevelRay ray;
  ray.from = start.point.head<2>();
  ray.along = along.head<2>() / along.z();
  ray.rise = along.z();
  Matrix23d by_along;
  by_along << Eigen::Matrix2d::Identity(), -ray.along;
  by_along /= along.z();
  ray.from_by_pose = start.by_pose.topRows<2>();
  ray.along_by_pose = by_along * (end.by_pose - start.by_pose);
  ray.along_by_tilt = by_along * end.by_tilt;
  ray.along_by_pixel = by_along * end.by_pixel;
  ray.rise_by_tilt = end.by_tilt.row(2);
  ray.rise_by_pixel = end.by_pixel.row(2);
  return ray;
}

}  // namespace

std::optional<DisparityDepth> DepthByDisparity(const UpwardCamera& camera,
                                               const Eigen::Vector3d& first_pose,
                                               const Eigen::Vector2d& first_pixel,
                                               const Eigen::Vector3d& second_pose,
                                               const Eigen::Vector2d& second_pixel) {
  const LevelRay first = LevelRayAt(camera, first_pose, first_pixel);
  const LevelRay second = LevelRayAt(camera, second_pose, second_pixel);
  const Eigen::Vector2d way = second.from - first.from;
  const Eigen::Vector2d moved = first.along - second.along;
  const double along_way = moved.dot(way);
  if (!(along_way > kMinDisparity_rad * way.norm())) return std::nullopt;
  const double height_m = way.squaredNorm() / along_way;
  DisparityDepth found;
  found.depth_m = height_m / second.rise;
  if (!(found.depth_m > kNearest_m)) return std::nullopt;

  // The height's derivatives, divided by how much depth a metre of height is.
  const Eigen::RowVector2d by_way =
      (2 * way - height_m * moved).transpose() / (along_way * second.rise);
  const Eigen::RowVector2d by_moved = -height_m * way.transpose() / (along_way * second.rise);
  const double by_rise = -found.depth_m / second.rise;
  found.by_first = {-by_way * first.from_by_pose + by_moved * first.along_by_pose,
                    by_moved * first.along_by_tilt,
                    by_moved * first.along_by_pixel};
  found.by_second = {by_way * second.from_by_pose - by_moved * second.along_by_pose,
                     -by_moved * second.along_by_tilt + by_rise * second.rise_by_tilt,
                     -by_moved * second.along_by_pixel + by_rise * second.rise_by_pixel};
  return found;
}

}  // namespace nightmap
