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
  ControllerOptions controller;
  double robot_radius_m = 0;      // 0: the radius that the path was planned for
  std::string start_heading_deg;  // empty: the direction in which the path starts
  std::string goal_heading_deg;   // empty: the path's goal heading
  double position_tolerance_m = 0.05;
  double heading_tolerance_deg = 5;
  double max_duration_s = 3600;  // simulated time
  NoiseOptions noise;            // none by default

  void Register(OptionList& list);
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
