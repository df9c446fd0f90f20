// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/wheel_motion.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

namespace nightmap {
namespace {

// Beyond what robots in buildings drive, and what a late stamp makes of a step.
constexpr double kMaxSpeed_m_per_s = 10;
constexpr double kMaxSpeed_rad_per_s = 10;
constexpr double kMaxLate_m = 0.5;
constexpr double kMaxLate_rad = 1;
// Beyond what a robot moves that comes to the origin of its odometry, exactly, by driving.
constexpr double kMaxToOrigin_m = 0.1;
constexpr double kMaxToOrigin_rad = 0.2;

double Sinc(double angle_rad) {
  return std::abs(angle_rad) < 1e-6 ? 1 : std::sin(angle_rad) / angle_rad;
}

// From one sample to the next, along an arc.
class Step {
 public:
  Step(const SignalSample& start, const SignalSample& end)
      : turn_rad_(std::remainder(end.value.z() - start.value.z(), 2 * std::numbers::pi)),
        chord_m_(Eigen::Rotation2Dd(-start.value.z()) *
                 (end.value.head<2>() - start.value.head<2>())) {}

  // Over a share of the time. On an arc it does not matter which.
  WheelMotion Part(double ratio) const {
    const double turn_rad = ratio * turn_rad_;
    const double arc_m = ratio / Sinc(turn_rad_ / 2);  // per metre of the whole chord
    const Eigen::Vector2d chord_m =
        arc_m * Sinc(turn_rad / 2) * (Eigen::Rotation2Dd((turn_rad - turn_rad_) / 2) * chord_m_);
    return {{Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad, Eigen::Vector3d::UnitZ())),
             {chord_m.x(), chord_m.y(), 0}},
            arc_m * chord_m_.norm(),
            std::abs(turn_rad)};
  }

 private:
  double turn_rad_;          // in [-pi, pi]
  Eigen::Vector2d chord_m_;  // in the wheels' frame at the start
};

WheelMotion operator*(const WheelMotion& a, const WheelMotion& b) {
  return {
      a.start_from_end * b.start_from_end, a.distance_m + b.distance_m, a.turn_rad + b.turn_rad};
}

}  // namespace

bool IsPossibleStep(const SignalSample& before, const SignalSample& after) {
  const double passed_s = 1e-9 * static_cast<double>(after.time_ns - before.time_ns);
  const double way_m = (after.value - before.value).head<2>().norm();
  const double turn_rad = std::remainder(after.value.z() - before.value.z(), 2 * std::numbers::pi);
  if (after.value.isZero(0) && (way_m > kMaxToOrigin_m || std::abs(turn_rad) > kMaxToOrigin_rad)) {
    return false;
  }
  return way_m <= kMaxLate_m + kMaxSpeed_m_per_s * passed_s &&
         std::abs(turn_rad) <= kMaxLate_rad + kMaxSpeed_rad_per_s * passed_s;
}

std::optional<WheelMotion> MotionBetween(const std::vector<SignalSample>& samples,
                                         double max_gap_s,
                                         std::int64_t start_ns,
                                         std::int64_t end_ns) {
  if (samples.empty() || start_ns < samples.front().time_ns || end_ns > samples.back().time_ns) {
    return std::nullopt;
  }
  WheelMotion motion;
  auto next = std::ranges::upper_bound(samples, start_ns, {}, &SignalSample::time_ns);
  for (std::int64_t time_ns = start_ns; time_ns < end_ns; ++next) {
    const SignalSample& before = *std::prev(next);
    const auto step_ns = static_cast<double>(next->time_ns - before.time_ns);
    if (step_ns > 1e9 * max_gap_s || !IsPossibleStep(before, *next)) return std::nullopt;
    const std::int64_t until_ns = std::min(end_ns, next->time_ns);
    motion = motion * Step(before, *next).Part(static_cast<double>(until_ns - time_ns) / step_ns);
    time_ns = until_ns;
  }
  return motion;
}

}  // namespace nightmap
