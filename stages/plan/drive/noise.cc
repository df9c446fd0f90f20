// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/drive/noise.h"

#include <cmath>

namespace nightmap {

Noise::Noise(const NoiseOptions& options, double wheel_distance_m, double period_s)
    : options_(options),
      wheel_distance_m_(wheel_distance_m),
      kept_(std::exp(-period_s / options.localization_time_s)),
      wheels_(static_cast<std::uint64_t>(options.seed), 0),
      localization_(static_cast<std::uint64_t>(options.seed), 1) {}

Twist Noise::Moved(const Twist& command) {
  if (options_.wheel_noise == 0) return command;
  const double apart_m_s = 0.5 * wheel_distance_m_ * command.omega_rad_s;
  const auto slip = [&] { return 1 + options_.wheel_noise * wheels_.Gaussian(); };
  const double left_m_s = (command.v_m_s - apart_m_s) * slip();
  const double right_m_s = (command.v_m_s + apart_m_s) * slip();
  return {0.5 * (left_m_s + right_m_s), (right_m_s - left_m_s) / wheel_distance_m_};
}

PlanarPose Noise::Told(const PlanarPose& pose) {
  if (options_.position_noise_m == 0 && options_.heading_noise_rad == 0) return pose;
  const double kept = is_first_ ? 0 : kept_;
  is_first_ = false;
  for (double& error : error_) {
    error = kept * error + std::sqrt(1 - kept * kept) * localization_.Gaussian();
  }
  return {pose.point_in_map + options_.position_noise_m * error_.head<2>(),
          WrapAngle(pose.heading_rad + options_.heading_noise_rad * error_.z())};
}

}  // namespace nightmap
