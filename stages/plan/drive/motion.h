// SPDX-License-Identifier: Apache-2.0
// Motion of a differential-drive robot: planar poses, twists, and their limits.
#pragma once

#include <Eigen/Core>

namespace nightmap {

struct PlanarPose {
  Eigen::Vector2d point_in_map = Eigen::Vector2d::Zero();
  double heading_rad = 0;  // counter-clockwise from x, in (-pi, pi]
};

// Command that is held for one control period.
struct Twist {
  double v_m_s = 0;        // forwards
  double omega_rad_s = 0;  // counter-clockwise

  bool IsRest() const { return v_m_s == 0 && omega_rad_s == 0; }
};

struct MotionLimits {
  double max_v_m_s = 0.5;
  double max_omega_rad_s = 1.0;
  double max_acceleration_m_s2 = 0.5;  // also the deceleration
  double max_angular_acceleration_rad_s2 = 2.0;
  double period_s = 0.05;  // control period
};

// Wraps into (-pi, pi].
double WrapAngle(double angle_rad);

// Exact: a twist held for a time moves the robot along an arc or a straight line.
PlanarPose Advance(const PlanarPose& pose, const Twist& twist, double duration_s);

// The twist nearest to `wish` that may follow `twist`: within both velocity limits and one period's
// acceleration, in whole millionths (which a file holds exactly). A wish out of reach is clamped.
Twist Reach(const Twist& twist, const Twist& wish, const MotionLimits& limits);

// The twist after `twist` when the robot brakes as hard as it may. It stays on its arc as far as
// the angular acceleration allows.
Twist Brake(const Twist& twist, const MotionLimits& limits);

// Largest speed for the next period from which the robot can still come to rest within a distance.
// Units agree: all m or all rad.
double SpeedToStopWithin(double distance, double acceleration, double period_s);

}  // namespace nightmap
