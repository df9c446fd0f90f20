// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_match/robot_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace nightmap {
namespace {

// Sigmas of a robot that may have been carried anywhere.
constexpr double kAnywhere_m = 100;
constexpr double kAnywhere_rad = 3;

}  // namespace

void RobotMotion::Add(const MatchedScan& scan) { before_last_ = std::exchange(last_, scan); }

Prediction RobotMotion::At(std::int64_t time_ns) const {
  if (!last_) return {};
  const WheelNoise& noise = options_.wheels;
  if (const auto motion = ByWheels(last_->time_ns, time_ns)) {
    const Rigid2 last_from_robot = ToRigid2(motion->start_from_end);
    const PosePrior prior{last_->start_from_robot * last_from_robot,
                          noise.PositionSigma_m(*motion),
                          noise.HeadingSigma_rad(*motion)};
    return {prior, last_from_robot, false};
  }
  const double passed_s = 1e-9 * static_cast<double>(time_ns - last_->time_ns);
  if (passed_s > kPause_s) {
    return {{last_->start_from_robot, kAnywhere_m, kAnywhere_rad}, std::nullopt, true};
  }
  const PosePrior prior{
      last_->start_from_robot * LastMotion(passed_s),
      noise.position_sigma_floor_m + options_.walking_sigma_m_per_s * passed_s,
      noise.heading_sigma_floor_rad + options_.walking_sigma_rad_per_s * passed_s};
  return {prior, std::nullopt, false};
}

std::optional<WheelMotion> RobotMotion::ByWheels(std::int64_t start_ns, std::int64_t end_ns) const {
  if (!wheels_) return std::nullopt;
  return MotionBetween(wheels_->samples, options_.wheels.max_gap_s, start_ns, end_ns);
}

Rigid2 RobotMotion::LastMotion(double passed_s) const {
  return before_last_ ? MotionOver(*before_last_, *last_, passed_s) : Rigid2{};
}

Rigid2 RobotMotion::MotionOver(const MatchedScan& a, const MatchedScan& b, double passed_s) {
  const double between_s = 1e-9 * static_cast<double>(b.time_ns - a.time_ns);
  const Rigid2 motion = a.start_from_robot.Inverse() * b.start_from_robot;
  const double ratio = std::min(passed_s / between_s, 1.0);
  return {ratio * motion.heading_rad, ratio * motion.translation};
}

}  // namespace nightmap
