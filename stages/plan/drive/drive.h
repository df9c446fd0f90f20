// SPDX-License-Identifier: Apache-2.0
// Drives a simulated robot along a planned path.
#pragma once

#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/io/grid_io.h"
#include "pipeline/plan/path_io.h"
#include "stages/plan/drive/clearance_map.h"
#include "stages/plan/drive/controller.h"
#include "stages/plan/drive/motion.h"
#include "stages/plan/drive/noise.h"

namespace nightmap {

struct DriveOptions {
  OPTION(double, robot_radius_m, 0, {0.0, 5.0},
         "radius of a round robot; 0: the radius for which the path was planned");
  OPTION(std::string, start_heading_deg, "",
         "heading of the robot at the start, counter-clockwise from x; \"\": along the path");
  OPTION(std::string, goal_heading_deg, "",
         "heading on arrival; \"\": that of the path's last point");
  ControllerOptions controller;
  OPTION_AT("max_v_m_s", controller.limits.max_v_m_s, {0.01, 10.0}, "largest speed, forwards");
  OPTION_AT("max_omega_rad_s", controller.limits.max_omega_rad_s, {0.01, 20.0},
            "largest angular velocity, in either direction");
  OPTION_AT("max_acceleration_m_s2", controller.limits.max_acceleration_m_s2, {0.01, 20.0},
            "largest acceleration and deceleration");
  OPTION_AT("max_angular_acceleration_rad_s2", controller.limits.max_angular_acceleration_rad_s2,
            {0.01, 100.0}, "largest angular acceleration and deceleration");
  OPTION_AT("period_s", controller.limits.period_s, {0.002, 0.5},
            "control period: a command holds this long");
  OPTION_AT("min_lookahead_m", controller.min_lookahead_m, {0.05, 10.0},
            "smallest distance along the path of the pursued point");
  OPTION_AT("max_lookahead_m", controller.max_lookahead_m, {0.05, 10.0},
            "largest distance along the path of the pursued point");
  OPTION_AT("margin_m", controller.margin_m, {0.0, 1.0},
            "room to keep between robot and obstacle where the path allows it");
  OPTION(double, position_tolerance_m, 0.05, {0.001, 10.0},
         "largest distance from the goal at which the robot may stop");
  OPTION(double, heading_tolerance_deg, 5, {0.1, 180.0},
         "largest difference from the goal's heading at which the robot may stop");
  OPTION(double, max_duration_s, 3600, {0.1, 1e5}, "longest simulated drive");
  OPTIONS_OF(NoiseOptions, noise);
  REGISTER_OPTIONS();
};

struct DriveInputs {
  OccupancyGrid grid;
  PlannedPath path;
};

struct DriveStep {
  PlanarPose pose;         // true pose at the step's time (step number times period)
  Twist command;           // holds until the next step; the last is zero
  double clearance_m = 0;  // see ClearanceMap
  double deviation_m = 0;  // distance from the path
};

struct DriveResult {
  int floor = 0;        // floor of the path
  Footprint footprint;  // radius that was used
  std::vector<DriveStep> steps;
  double period_s = 0;
  double path_length_m = 0;
  double length_m = 0;  // driven length
  double min_clearance_m = 0;
  double max_deviation_m = 0;
  std::size_t num_goals = 0;
  double position_error_m = 0;   // largest error at a goal
  double heading_error_deg = 0;  // at the last goal

  double Duration_s() const { return period_s * static_cast<double>(steps.size() - 1); }
};

// The robot starts at rest on the path's first point and stops at each goal of the path. Without
// noise each step's pose follows exactly from the pose and command before it, so the commands alone
// replay the drive. With noise the controller sees noisy poses, but collisions and arrival are
// judged by the true ones. Deterministic. Throws UsageError on a malformed option, DataError when a
// point of the path is not on the grid, ThresholdError when the robot collides, does not arrive
// within max_duration_s, or arrives outside a tolerance.
DriveResult RunDrive(const DriveOptions& options, const DriveInputs& inputs, Progress& progress);

}  // namespace nightmap
