// SPDX-License-Identifier: Apache-2.0
// Checks of a scanner's description against all its scans together, once they are read.
#pragma once

#include <optional>
#include <vector>

#include "pipeline/recording/robot_body.h"
#include "pipeline/recording/site_config.h"

namespace nightmap {

// Facts of a scanner that its scans tell and its description does not.
struct FoundInScans {
  // The range that it writes where it hit nothing, if no limit is stated (scan_ranges.h).
  std::optional<float> range_of_no_hit_m;
  // Its view of its robot, beyond what is stated (robot_body.h); none if that cannot be told.
  std::optional<RobotBody> body;
  bool is_body_left_out = false;
};

// Lets the beams share the circle (scan_angles.h); takes those of blind sectors, with their
// borders, and ranges below min_range_m for not measured; finds a limit that is not stated, which
// becomes that of the scans, and the robot, which is left out where it is certain and neither of
// the two is stated. Pure.
FoundInScans FinishScans(const SensorConfig& sensor, std::vector<SignalSample>* scans);

}  // namespace nightmap
