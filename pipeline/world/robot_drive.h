// SPDX-License-Identifier: Apache-2.0
// Where the robot is at any time: on the floor below its camera, level, and turned as the camera.
#pragma once

#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "pipeline/world/route.h"

namespace nightmap {

// The motion between two points is linear in position and heading, and this is the exact truth:
// all sensors measure this motion. Without differential_drive the robot may move to the side,
// because the camera's heading leads its path in corners. Immutable and safe to share between
// threads.
class RobotDrive {
 public:
  // The robot is at frames[i] at i / frame_rate_hz seconds. `frames` is not empty.
  RobotDrive(std::vector<RoutePoint> frames, double frame_rate_hz);

  // The time of the last frame.
  double Duration_s() const;
  // The robot stands still before the first and after the last frame.
  RoutePoint At(double time_s) const;

 private:
  std::vector<RoutePoint> frames_;
  double frame_rate_hz_;
};

// The drive of a recording: it passes every frame of SampleFrames. With differential_drive it has
// five points per frame, so that the robot slides to the side by less than a millimetre each.
RobotDrive PlanDrive(const FloorLayout& layout, const RouteOptions& options, double frame_rate_hz);

// building_from_robot: x forward, y left, z up, origin on the floor.
Rigid3 RobotPose(const RoutePoint& point);

}  // namespace nightmap
