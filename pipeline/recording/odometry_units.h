// SPDX-License-Identifier: Apache-2.0
// Units of the odometry, by the way of the wheels.
#pragma once

#include <filesystem>
#include <vector>

#include "pipeline/recording/signals_io.h"
#include "pipeline/recording/site_config.h"

namespace nightmap {

// The median speed over a second, of the seconds in which the robot moves; 0 when it hardly does.
double UsualSpeed_m_per_s(const std::vector<SignalSample>& poses);

// Whether headings look like degrees: they exceed a turn in rad, and taken as degrees they agree
// far better with the directions of motion, forward or backward. Pure.
bool LookLikeDegrees(const std::vector<SignalSample>& poses);
// Likewise of headings that are sums of changes, with which motion agrees in any unit: as radians
// the robot turns as no robot does.
bool SumsLookLikeDegrees(const std::vector<SignalSample>& poses);

// Throws DataError, which names the file and says what to write, when the units of odometry cannot
// be: positions by a speed that no robot in a building has, and headings that look like degrees
// while heading_unit is not stated.
void DemandUnits(const SensorConfig& sensor,
                 const std::vector<SignalSample>& poses,
                 const std::filesystem::path& path);

}  // namespace nightmap
