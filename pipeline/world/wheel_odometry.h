// SPDX-License-Identifier: Apache-2.0
// Measurements of the robot's wheels: the sum of its motions, each with bias and noise.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "pipeline/world/robot_drive.h"
#include "pipeline/world/synthetic_options.h"

namespace nightmap {

// Poses are (x m, y m, heading rad), begin at zero, and drift. Without bias and noise they are the
// robot's true poses in its first one. A motion over distance d with a turn r, both since the
// previous sample, is measured as
//   distance  (1 + scale_bias) d + distance_noise_m sqrt(d) gaussian    in the true direction
//   turn      r + heading_bias_rad_per_m d + heading_noise_rad sqrt(|r|) gaussian
//               + heading_noise_rad_per_root_m sqrt(d) gaussian
// so that the deviations do not depend on the sample rate. Wheels that slip take the robot's
// distance d for (1 + slip.ratio) d. `noise_seed` alone decides the noise.
class WheelOdometry {
 public:
  // Samples at i / options.rate_hz from 0 to the end of the drive.
  WheelOdometry(const RobotDrive& drive,
                const WheelOptions& options,
                std::uint64_t noise_seed,
                const WheelSlipOptions& slip = {});

  const std::vector<Eigen::Vector3d>& Samples() const { return samples_; }
  double TimeOf_s(std::size_t sample) const { return static_cast<double>(sample) / rate_hz_; }
  // The time of the last sample.
  double Duration_s() const { return TimeOf_s(samples_.size() - 1); }
  // Linear between samples; 0 <= time_s <= Duration_s().
  Eigen::Vector3d At(double time_s) const;

 private:
  double rate_hz_;
  std::vector<Eigen::Vector3d> samples_;
};

}  // namespace nightmap
