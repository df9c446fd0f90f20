// SPDX-License-Identifier: Apache-2.0
// Where a camera that looks straight up truly is: on the robot, with a mounting tilt, and shaken.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "pipeline/world/robot_drive.h"
#include "pipeline/world/synthetic_options.h"

namespace nightmap {

// Roll and pitch are the sum of a constant, drawn with sigma mount_tilt_rad, and of a vibration: an
// autoregressive process of first order with sigma vibration_rad and correlation time 0.05 s,
// linear between its steps of 20 ms. The camera turns about its centre, which stays above the
// robot's origin. `seed` alone decides both. Immutable and safe to share between threads.
class UpwardMotion {
 public:
  UpwardMotion(RobotDrive drive, const UpwardMountOptions& options, std::uint64_t seed);

  const RobotDrive& Drive() const { return drive_; }
  // building_from_robot: x forward, y left, z up, origin on the floor.
  Rigid3 RobotAt(double time_s) const { return RobotPose(drive_.At(time_s)); }
  // building_from_camera: without tilt the axes of the robot.
  Rigid3 CameraAt(double time_s) const;
  // Roll and pitch of the mounting (rad), without vibration.
  const Eigen::Vector2d& MountTilt_rad() const { return mount_tilt_rad_; }

 private:
  RobotDrive drive_;
  double camera_height_m_;
  Eigen::Vector2d mount_tilt_rad_;
  std::vector<Eigen::Vector2d> vibration_rad_;
};

}  // namespace nightmap
