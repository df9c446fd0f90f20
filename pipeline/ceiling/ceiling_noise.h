// SPDX-License-Identifier: Apache-2.0
// How far EKF-SLAM under a ceiling trusts pictures, wheels and mounting.
#pragma once

#include "pipeline/base/options.h"

namespace nightmap {

// Standard deviations of what the filter does not know.
struct CeilingNoise {
  OPTION(double, pixel_sigma_px, 0.4, {0.01, 10}, "noise of a corner in a picture");
  // The wheels' distance and heading after 1 m, and heading after a turn of 1 rad; they grow with
  // the root of the way, as the sum of independent errors does.
  OPTION(double, distance_sigma_m, 0.03, {1e-4, 1},
         "noise of the wheels' distance after 1 m; grows with the distance's root");
  OPTION(double, heading_sigma_rad, 0.02, {1e-5, 1},
         "noise of the wheels' heading after 1 m; grows with the distance's root");
  OPTION(double, turn_sigma_rad, 0.05, {1e-5, 1},
         "noise of the wheels' heading after a turn of 1 rad; grows with the turn's root");
  // Some errors are there all the time.
  OPTION(double, scale_sigma, 0.01, {0, 0.5},
         "share by which all distances of the wheels may be wrong; no picture tells it, so the "
         "map's size is as wrong as the wheels are");
  OPTION(double, heading_bias_sigma_rad_per_m, 0.005, {0, 1},
         "turn that the wheels may make up per metre all the time");
  OPTION(double, mounting_tilt_sigma_rad, 0.02, {0, 0.3},
         "tilt of the camera against robot_from_camera, about each of its axes");
  // Vibration tilts the robot anew in each frame.
  OPTION(double, vibration_sigma_rad, 0.003, {0, 0.1},
         "tilt of the driving robot, from frame to frame");
  // A robot without odometry may go on at another speed and turn than before, all the time.
  OPTION(double, unknown_speed_m_per_s, 0.5, {0, 10}, "speed of a robot whose wheels say nothing");
  double unknown_turn_rad_per_s = 0.5;  // turning speed of a robot whose wheels say nothing
  REGISTER_OPTIONS();
};

}  // namespace nightmap
