// SPDX-License-Identifier: Apache-2.0
// How far EKF-SLAM under a ceiling trusts pictures, wheels and mounting.
#pragma once

#include "pipeline/base/options.h"

namespace nightmap {

// Standard deviations of what the filter does not know.
struct CeilingNoise {
  double pixel_sigma_px = 0.4;
  // The wheels' distance and heading after 1 m, and heading after a turn of 1 rad; they grow with
  // the root of the way, as the sum of independent errors does.
  double distance_sigma_m = 0.03;
  double heading_sigma_rad = 0.02;
  double turn_sigma_rad = 0.05;
  // Some errors are there all the time.
  double scale_sigma = 0.01;
  double heading_bias_sigma_rad_per_m = 0.005;
  double mounting_tilt_sigma_rad = 0.02;
  // Vibration tilts the robot anew in each frame.
  double vibration_sigma_rad = 0.003;
  // A robot without odometry may go on at another speed and turn than before, all the time.
  double unknown_speed_m_per_s = 0.5;
  double unknown_turn_rad_per_s = 0.5;

  void Register(OptionList& list);
};

}  // namespace nightmap
