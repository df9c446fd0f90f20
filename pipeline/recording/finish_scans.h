// SPDX-License-Identifier: Apache-2.0
// What a scanner's description says of all its scans together, once they are read.
#pragma once

#include <optional>
#include <vector>

#include "pipeline/recording/site_config.h"

namespace nightmap {

// The range of a beam that measured nothing of the building: it lies in a blind sector, or ended on
// the robot. It is no hit, and no beam that hit nothing either, so nothing is free along it.
inline constexpr float kNotMeasured_m = -1;

// Lets the beams share the circle (scan_angles.h); takes those of blind sectors, with their
// borders, and ranges below min_range_m for not measured; finds a limit that is not stated
// (scan_ranges.h), and returns it. Pure.
std::optional<float> FinishScans(const SensorConfig& sensor, std::vector<SignalSample>* scans);

}  // namespace nightmap
