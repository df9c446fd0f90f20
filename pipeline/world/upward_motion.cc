// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/upward_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/base/random.h"

namespace nightmap {

namespace {

constexpr std::uint64_t kTiltStream = 708;
constexpr std::uint64_t kVibrationStream = 709;
constexpr double kVibrationStep_s = 0.02;
constexpr double kCorrelation_s = 0.05;
// Before the drive, where an exposure may begin. Half a step more, so that at 10 frames per second
// no step ends within an exposure, and its mean is the pose at its middle.
constexpr double kVibrationLead_s = 1.01;

Eigen::Vector2d GaussianPair(Random& random) {
  const double first = random.Gaussian();
  return {first, random.Gaussian()};
}

}  // namespace

UpwardMotion::UpwardMotion(RobotDrive drive, const UpwardMountOptions& options, std::uint64_t seed)
    : drive_(std::move(drive)), camera_height_m_(options.camera_height_m) {
  Random tilt(seed, kTiltStream);
  mount_tilt_rad_ = options.mount_tilt_rad * GaussianPair(tilt);
  Random random(seed, kVibrationStream);
  const double keep = std::exp(-kVibrationStep_s / kCorrelation_s);
  // Between steps the variance is less, (2 + keep) / 3 of theirs on average.
  const double sigma_rad = options.vibration_rad / std::sqrt((2 + keep) / 3);
  const double renew = std::sqrt(1 - keep * keep) * sigma_rad;
  vibration_rad_ = {sigma_rad * GaussianPair(random)};
  const double duration_s = drive_.Duration_s() + 2 * kVibrationLead_s;
  for (double time_s = 0; time_s < duration_s; time_s += kVibrationStep_s) {
    vibration_rad_.push_back(keep * vibration_rad_.back() + renew * GaussianPair(random));
  }
}

Rigid3 UpwardMotion::CameraAt(double time_s) const {
  const double last = static_cast<double>(vibration_rad_.size() - 1);
  const double at = std::clamp((time_s + kVibrationLead_s) / kVibrationStep_s, 0.0, last);
  const auto before = static_cast<std::size_t>(at);
  const std::size_t after = std::min(before + 1, vibration_rad_.size() - 1);
  const double t = at - static_cast<double>(before);
  const Eigen::Vector2d tilt_rad =
      mount_tilt_rad_ + (1 - t) * vibration_rad_[before] + t * vibration_rad_[after];
  const Rigid3 robot_from_camera{
      Eigen::Quaterniond(Eigen::AngleAxisd(tilt_rad[0], Eigen::Vector3d::UnitX()) *
                         Eigen::AngleAxisd(tilt_rad[1], Eigen::Vector3d::UnitY())),
      {0, 0, camera_height_m_}};
  return RobotAt(time_s) * robot_from_camera;
}

}  // namespace nightmap
