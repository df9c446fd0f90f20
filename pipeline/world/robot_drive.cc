// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/robot_drive.h"

#include <algorithm>
#include <utility>

namespace nightmap {

RobotDrive::RobotDrive(std::vector<RoutePoint> frames, double frame_rate_hz)
    : frames_(std::move(frames)), frame_rate_hz_(frame_rate_hz) {}

double RobotDrive::Duration_s() const {
  return static_cast<double>(frames_.size() - 1) / frame_rate_hz_;
}

RoutePoint RobotDrive::At(double time_s) const {
  const double last = static_cast<double>(frames_.size() - 1);
  const double at = std::clamp(time_s * frame_rate_hz_, 0.0, last);
  const auto before = static_cast<std::size_t>(at);
  const RoutePoint& a = frames_[before];
  const RoutePoint& b = frames_[std::min(before + 1, frames_.size() - 1)];
  const double t = at - static_cast<double>(before);
  return {a.position + t * (b.position - a.position),
          a.heading_rad + t * (b.heading_rad - a.heading_rad),
          a.floor_m + t * (b.floor_m - a.floor_m)};
}

RobotDrive PlanDrive(const FloorLayout& layout, const RouteOptions& options, double frame_rate_hz) {
  const int points_per_frame = options.differential_drive ? 5 : 1;
  return {SampleFrames(PlanPath(layout, options), options, points_per_frame),
          frame_rate_hz * points_per_frame};
}

Rigid3 RobotPose(const RoutePoint& point) {
  const Eigen::AngleAxisd turn(point.heading_rad, Eigen::Vector3d::UnitZ());
  return {Eigen::Quaterniond(turn), {point.position.x(), point.position.y(), point.floor_m}};
}

}  // namespace nightmap
