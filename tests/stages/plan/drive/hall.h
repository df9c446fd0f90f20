// SPDX-License-Identifier: Apache-2.0
// A place to drive in.
#pragma once

#include "stages/plan/drive/drive.h"
#include "tests/small_grids.h"
#include "tests/test_data.h"

namespace nightmap {

inline constexpr double kRadius_m = 0.2;
inline constexpr double kDegrees = 3.14159265358979323846 / 180;

inline DriveResult Drive(const DriveOptions& options, const DriveInputs& inputs) {
  return RunDrive(options, inputs, NoProgress());
}

// Free but for what the tests put there, 6 m a side, and an L-shaped path.
inline DriveInputs Hall() {
  DriveInputs inputs;
  inputs.grid = FreeGrid(120, 120, 0.05);
  inputs.path.legs_in_map = {{{1, 1}, {4, 1}, {4, 5}}};
  inputs.path.goal_heading_rad = 90 * kDegrees;
  inputs.path.robot_radius_m = kRadius_m;
  return inputs;
}

}  // namespace nightmap
