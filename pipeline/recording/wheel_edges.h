// SPDX-License-Identifier: Apache-2.0
// Motion of the cameras between frames, from the odometry of the wheels.
#pragma once

#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/io/edges_io.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/recording/wheel_motion.h"

namespace nightmap {

// How far to trust the wheels on the way from one frame to the next. Standard deviations grow
// linearly with the distance driven and the angle turned, as in the odometry motion model of Thrun,
// Burgard, Fox, "Probabilistic Robotics" (2005), 5.4. Wheels stay on the ground: height, roll and
// pitch of the wheels' frame change by no more than `plane_sigma`.
struct WheelNoise {
  OPTION(double, position_sigma_floor_m, 0.002, {1e-6, 10},
         "standard deviation of x and y from frame to frame");
  OPTION(double, position_sigma_per_distance, 0.05, {0, 10},
         "added to it, in metres per metre driven");
  double position_sigma_m_per_rad = 0.01;  // added to it per radian turned
  OPTION(double, heading_sigma_floor_rad, 0.002, {1e-6, 10},
         "standard deviation of the heading from frame to frame");
  double heading_sigma_rad_per_m = 0.02;  // added to it per metre driven
  OPTION(double, heading_sigma_per_turn, 0.05, {0, 10},
         "added to it, in radians per radian turned");
  OPTION(double, plane_sigma_m, 0.005, {1e-6, 10},
         "standard deviation of the height from frame to frame");
  double plane_sigma_rad = 0.01;  // standard deviation of roll and pitch from frame to frame
  OPTION(double, max_gap_s, 0.5, {0.001, 60}, "an edge spans no longer gap between samples");

  // Standard deviations after a motion.
  double PositionSigma_m(const WheelMotion& motion) const;
  double HeadingSigma_rad(const WheelMotion& motion) const;
  REGISTER_OPTIONS();
};

// One odometry edge per two consecutive frames of a sequence:
//   camera_b_from_camera_a = camera_from_robot * robot_b_from_robot_a * robot_from_camera.
// `odometry` holds samples x, y (m), heading (rad) of the wheels' frame: x forward, z up. Between
// two samples the wheels drive an arc at constant speed, so straight and circular motion is exact.
// Frames before the first or after the last sample, or with a gap between them, get no edge. The
// covariance is that of SensorEdge. Frames ascend in time within a sequence; their camera_idx is in
// `cameras`. Pure and deterministic.
SensorEdges WheelEdges(const WheelNoise& noise,
                       const std::vector<FrameRecord>& frames,
                       const std::vector<RgbdCamera>& cameras,
                       const Signal& odometry);

}  // namespace nightmap
