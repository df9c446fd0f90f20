// SPDX-License-Identifier: Apache-2.0
// A place to drive in.
#pragma once

#include "stages/plan/drive/drive.h"

namespace nightmap {

inline constexpr double kRadius_m = 0.2;
inline constexpr double kDegrees = 3.14159265358979323846 / 180;

inline DriveResult Drive(const DriveOptions& options, const DriveInputs& inputs) {
  Progress progress("drive", false);
  return RunDrive(options, inputs, progress);
}

// Free but for what the tests put there, 6 m a side, and an L-shaped path.
inline DriveInputs Hall() {
  DriveInputs inputs;
  inputs.grid = {120, 120, 0.05, {0, 0}, {}};
  inputs.grid.cells.assign(120 * 120, kFreeCell);
  inputs.path.legs_in_map = {{{1, 1}, {4, 1}, {4, 5}}};
  inputs.path.goal_heading_rad = 90 * kDegrees;
  inputs.path.robot_radius_m = kRadius_m;
  return inputs;
}

}  // namespace nightmap
