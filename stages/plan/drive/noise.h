// SPDX-License-Identifier: Apache-2.0
// Simulated noise: slip of the wheels and error of the localization.
#pragma once

#include <Eigen/Core>

#include "pipeline/base/options.h"
#include "pipeline/base/random.h"
#include "stages/plan/drive/motion.h"

namespace nightmap {

// Standard deviations of normal noise; 0 turns it off.
struct NoiseOptions {
  OPTION(double, wheel_noise, 0, {0.0, 0.5},
         "standard deviation of a wheel's travel per control period, relative to that travel; the "
         "wheels are as far apart as the robot is wide");
  OPTION(double, position_noise_m, 0, {0.0, 1.0},
         "standard deviation of the position that the controller is told, in x and in y");
  OPTION(double, heading_noise_rad, 0, {0.0, 1.0},
         "standard deviation of the heading that the controller is told");
  OPTION(double, localization_time_s, 1, {0.0, 100.0},
         "time constant with which the error of a told pose decays; 0: independent errors");
  OPTION(int, seed, 0, {0, 2e9}, "seed of all noise");

  REGISTER_OPTIONS();

  bool IsNone() const {
    return wheel_noise == 0 && position_noise_m == 0 && heading_noise_rad == 0;
  }
};

// The error of a told pose is a first-order Gauss-Markov process, because a filter's error persists
// for a while instead of changing anew in each period. Deterministic in the seed.
class Noise {
 public:
  Noise(const NoiseOptions& options, double wheel_distance_m, double period_s);

  // The motion that the robot makes during a period in which it was given a command.
  Twist Moved(const Twist& command);
  // The pose that the controller is told at the start of the next period.
  PlanarPose Told(const PlanarPose& pose);

 private:
  NoiseOptions options_;
  double wheel_distance_m_;
  double kept_;  // share of an error that remains after one period
  Random wheels_;
  Random localization_;
  bool is_first_ = true;
  Eigen::Vector3d error_ = Eigen::Vector3d::Zero();  // x, y, heading; in standard deviations
};

}  // namespace nightmap
