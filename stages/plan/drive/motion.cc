// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/drive/motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace nightmap {
namespace {

constexpr double kUnit = 1e-6;         // of commanded velocities
constexpr double kMinTurn_rad = 1e-9;  // smallest turn that counts as an arc

// Works in whole units, so that sums stay exact.
double ReachOne(double from, double wish, double max_speed, double max_change) {
  const double start = std::round(from / kUnit);
  const double top = std::floor(max_speed / kUnit * (1 + 1e-12));
  const double step = std::floor(max_change / kUnit * (1 + 1e-12));
  const double units = std::clamp(std::round(wish / kUnit), -top, top);
  return std::clamp(units, start - step, start + step) * kUnit;
}

}  // namespace

double WrapAngle(double angle_rad) {
  constexpr double kTurn = 2 * std::numbers::pi;
  const double wrapped = angle_rad - kTurn * std::round(angle_rad / kTurn);
  return wrapped <= -std::numbers::pi ? wrapped + kTurn : wrapped;
}

PlanarPose Advance(const PlanarPose& pose, const Twist& twist, double duration_s) {
  const double turn_rad = twist.omega_rad_s * duration_s;
  const double length_m = twist.v_m_s * duration_s;
  // The chord of an arc has the direction of the arc's middle.
  const double half_rad = 0.5 * turn_rad;
  const double chord_m =
      std::abs(half_rad) < kMinTurn_rad ? length_m : length_m * std::sin(half_rad) / half_rad;
  const double direction_rad = pose.heading_rad + half_rad;
  return {pose.point_in_map +
              chord_m * Eigen::Vector2d(std::cos(direction_rad), std::sin(direction_rad)),
          WrapAngle(pose.heading_rad + turn_rad)};
}

Twist Reach(const Twist& twist, const Twist& wish, const MotionLimits& limits) {
  return {ReachOne(twist.v_m_s,
                   wish.v_m_s,
                   limits.max_v_m_s,
                   limits.max_acceleration_m_s2 * limits.period_s),
          ReachOne(twist.omega_rad_s,
                   wish.omega_rad_s,
                   limits.max_omega_rad_s,
                   limits.max_angular_acceleration_rad_s2 * limits.period_s)};
}

Twist Brake(const Twist& twist, const MotionLimits& limits) {
  const Twist slower = Reach(twist, {0, 0}, limits);
  const double ratio = twist.v_m_s > 0 ? slower.v_m_s / twist.v_m_s : 0;
  return Reach(twist, {slower.v_m_s, ratio * twist.omega_rad_s}, limits);
}

double SpeedToStopWithin(double distance, double acceleration, double period_s) {
  if (distance <= 0) return 0;
  const double step = acceleration * period_s;  // change of speed per period
  const double units = distance / (step * period_s);
  // Speeds s, s - 1, ... down to zero, in steps, cover (m + 1) (s - m / 2) with m whole steps in s.
  const double num_whole = std::floor(0.5 * (std::sqrt(1 + 8 * units) - 1));
  return step * (units / (num_whole + 1) + 0.5 * num_whole);
}

}  // namespace nightmap
