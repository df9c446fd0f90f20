// SPDX-License-Identifier: Apache-2.0
// What a simulation without noise leaves out: wheels slip, and a robot knows its pose only so well.
#pragma once

#include <Eigen/Core>

#include "pipeline/base/options.h"
#include "pipeline/base/random.h"
#include "stages/drive/motion.h"

namespace nightmap {

// Standard deviations of normal noise; 0: none.
struct NoiseOptions {
  double wheel_noise = 0;          // of a wheel's way in a control period, relative to it
  double position_noise_m = 0;     // of the position the controller is told, along x and along y
  double heading_noise_rad = 0;    // of the heading it is told
  double localization_time_s = 1;  // a told pose's error fades with this time constant
  int seed = 0;

  bool IsNone() const {
    return wheel_noise == 0 && position_noise_m == 0 && heading_noise_rad == 0;
  }
  void Register(OptionList& list);
};

// The error of a told pose is a first-order Gauss-Markov process: a filter's estimate errs for a
// while in one direction, not anew in each period. Deterministic by the seed.
class Noise {
 public:
  Noise(const NoiseOptions& options, double wheel_distance_m, double period_s);

  // What the robot does in a period for which it was given a command.
  Twist Moved(const Twist& command);
  // What the controller is told at the start of the next period.
  PlanarPose Told(const PlanarPose& pose);

 private:
  NoiseOptions options_;
  double wheel_distance_m_;
  double kept_;  // of an error from one period to the next
  Random wheels_;
  Random localization_;
  bool is_first_ = true;
  Eigen::Vector3d error_ = Eigen::Vector3d::Zero();  // x, y, heading, in standard deviations
};

}  // namespace nightmap
