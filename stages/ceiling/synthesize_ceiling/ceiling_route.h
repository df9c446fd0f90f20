// SPDX-License-Identifier: Apache-2.0
// How a differential-drive robot drives the legs of a CeilingPlan.
#pragma once

#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/world/robot_drive.h"
#include "stages/ceiling/synthesize_ceiling/ceiling_plan.h"

namespace nightmap {

struct CeilingRouteOptions {
  OPTION(double, speed_m_per_s, 0.6, {0.01, 5}, "speed of the robot on straight ways");
  OPTION(double, turn_rate_rad_per_s, 0.8, {0.01, 10}, "turning on the spot; at most in corners");
  REGISTER_OPTIONS();
};

// A place on a leg: x, y in the building frame (m), heading of the tangent (rad, unwrapped).
struct CeilingStation {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  double heading_rad = 0;
  double at_m = 0;         // distance along the leg
  bool is_corner = false;  // on an arc
};

// The turn between two headings, in (-pi, pi]; half a turn is to the left.
double ShorterTurn_rad(double from_rad, double to_rad);

// The leg with its corners replaced by arcs, every 5 mm. A corner nearer to its neighbours than
// twice the radius has a smaller arc.
std::vector<CeilingStation> RoundCorners(const CeilingLeg& leg, double radius_m);

// The drive at 200 points per second: it stands still, then drives all legs. Heading is the
// tangent, never to the side. Speed rises and falls by the acceleration, is 0 at the ends of legs,
// and no turn is quicker than the turn rate. Between legs the robot turns on the spot, the shorter
// way (half a turn: to the left).
RobotDrive DriveCeilingLegs(const std::vector<CeilingLeg>& legs,
                            const CeilingRouteOptions& options);

// The first `duration_s` of a drive; all of it when it is shorter.
RobotDrive CutDrive(const RobotDrive& drive, double duration_s);

}  // namespace nightmap
