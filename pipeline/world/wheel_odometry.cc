// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/wheel_odometry.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/random.h"

namespace nightmap {

namespace {

constexpr std::uint64_t kWheelNoiseStream = 411;
constexpr double kTimeTolerance_s = 1e-9;  // rounding of i / rate_hz

Eigen::Vector2d Turned(const Eigen::Vector2d& vector, double angle_rad) {
  const double c = std::cos(angle_rad);
  const double s = std::sin(angle_rad);
  return {c * vector.x() - s * vector.y(), s * vector.x() + c * vector.y()};
}

// (x, y, heading) of b in the frame of a.
Eigen::Vector3d TrueMotion(const RoutePoint& a, const RoutePoint& b) {
  const Eigen::Vector2d way = Turned(b.position - a.position, -a.heading_rad);
  return {way.x(), way.y(), b.heading_rad - a.heading_rad};
}

Eigen::Vector3d MeasureMotion(const Eigen::Vector3d& motion,
                              const WheelOptions& options,
                              Random random) {
  const double distance_m = motion.head<2>().norm();
  const double turn_rad = motion[2];
  const double distance_noise_m =
      options.distance_noise_m * std::sqrt(distance_m) * random.Gaussian();
  const double turn_noise_rad =
      options.heading_noise_rad * std::sqrt(std::abs(turn_rad)) * random.Gaussian();
  const double drift_rad =
      options.heading_noise_rad_per_root_m * std::sqrt(distance_m) * random.Gaussian();
  Eigen::Vector3d measured = motion;
  if (distance_m > 0) measured.head<2>() *= 1 + options.scale_bias + distance_noise_m / distance_m;
  measured[2] += options.heading_bias_rad_per_m * distance_m + turn_noise_rad + drift_rad;
  return measured;
}

// Share of the time between two samples in which the wheels slip.
double SlippingShare(const WheelSlipOptions& slip, double from_s, double to_s) {
  const double begin_s = std::max(from_s, slip.at_s);
  const double end_s = std::min(to_s, slip.at_s + slip.duration_s);
  return std::max(0.0, end_s - begin_s) / (to_s - from_s);
}

}  // namespace

WheelOdometry::WheelOdometry(const RobotDrive& drive,
                             const WheelOptions& options,
                             std::uint64_t noise_seed,
                             const WheelSlipOptions& slip)
    : rate_hz_(options.rate_hz), samples_{Eigen::Vector3d::Zero()} {
  RoutePoint before = drive.At(0);
  for (std::size_t i = 1; TimeOf_s(i) <= drive.Duration_s() + kTimeTolerance_s; ++i) {
    const RoutePoint now = drive.At(TimeOf_s(i));
    Eigen::Vector3d turned = TrueMotion(before, now);
    turned.head<2>() *= 1 + slip.ratio * SlippingShare(slip, TimeOf_s(i - 1), TimeOf_s(i));
    const Eigen::Vector3d motion =
        MeasureMotion(turned, options, Random(noise_seed, kWheelNoiseStream, i));
    Eigen::Vector3d pose = samples_.back();
    pose.head<2>() += Turned(motion.head<2>(), pose[2]);
    pose[2] += motion[2];
    samples_.push_back(pose);
    before = now;
  }
}

Eigen::Vector3d WheelOdometry::At(double time_s) const {
  const double at = std::clamp(time_s * rate_hz_, 0.0, static_cast<double>(samples_.size() - 1));
  const auto before = static_cast<std::size_t>(at);
  const std::size_t after = std::min(before + 1, samples_.size() - 1);
  const double t = at - static_cast<double>(before);
  return samples_[before] + t * (samples_[after] - samples_[before]);
}

}  // namespace nightmap
