// SPDX-License-Identifier: Apache-2.0
// Drives a simulated robot along a planned path.
#pragma once

#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/io/grid_io.h"
#include "pipeline/io/path_io.h"
#include "stages/drive/clearance.h"
#include "stages/drive/controller.h"
#include "stages/drive/motion.h"
#include "stages/drive/noise.h"

namespace nightmap {

struct DriveOptions {
  ControllerOptions controller;
  double robot_radius_m = 0;      // 0: the radius the path was planned for
  std::string start_heading_deg;  // empty: along the path
  std::string goal_heading_deg;   // empty: the path's last
  double position_tolerance_m = 0.05;
  double heading_tolerance_deg = 5;
  double max_duration_s = 3600;  // of the simulated drive
  NoiseOptions noise;            // none by default

  void Register(OptionList& list);
};

struct DriveInputs {
  OccupancyGrid grid;
  PlannedPath path;
};

struct DriveStep {
  PlanarPose pose;         // true, at the step's time, the step's number times the period
  Twist command;           // from then on until the next step; the last is none
  double clearance_m = 0;  // see ClearanceMap
  double deviation_m = 0;  // from the path
};

struct DriveResult {
  int floor = 0;        // of the path
  Footprint footprint;  // as used
  std::vector<DriveStep> steps;
  double period_s = 0;
  double path_length_m = 0;
  double length_m = 0;  // driven
  double min_clearance_m = 0;
  double max_deviation_m = 0;
  std::size_t num_goals = 0;
  double position_error_m = 0;   // largest at a goal
  double heading_error_deg = 0;  // at the last

  double Duration_s() const { return period_s * static_cast<double>(steps.size() - 1); }
};

// The robot starts at rest on the path's first point, and stops at each goal of the path. Without
// noise each step's pose follows exactly from the one before it and its command, so commands alone
// replay the drive. With noise the controller sees other poses than the true ones, by which
// collisions and arrival are judged all the same. Deterministic. Throws UsageError on a malformed
// option, DataError when a point of the path is not on the grid, ThresholdError when the robot
// collides, does not arrive within max_duration_s, or arrives outside of a tolerance.
DriveResult RunDrive(const DriveOptions& options, const DriveInputs& inputs, Progress& progress);

}  // namespace nightmap
