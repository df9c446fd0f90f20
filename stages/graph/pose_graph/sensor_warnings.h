// SPDX-License-Identifier: Apache-2.0
// Tells in words which mounting pose or clock of a sensor is wrong, and what to write instead.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "stages/graph/pose_graph/pose_graph.h"

namespace nightmap {

// Whether a value exceeds 4 of its deviations and the option's threshold.
bool IsMountingWrong(const CalibrationWarnings& options, const SensorCalibration& calibration);
bool IsClockWrong(const CalibrationWarnings& options, const SensorCalibration& calibration);

// One sentence for each; empty where nothing is wrong.
std::vector<std::string> WarningsOf(const CalibrationWarnings& options,
                                    const std::string& sensor,
                                    const SensorCalibration& calibration);

void LogWarnings(const std::vector<SensorRecord>& sensors);

// Values and deviations by name; what the motion does not tell is null.
nlohmann::json Summarize(const SensorCalibration& calibration);

}  // namespace nightmap
