// SPDX-License-Identifier: Apache-2.0
// Describes in words what z = 0 is: for the log, report.json and the report page.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "stages/dense/map_frame/map_frame.h"

namespace nightmap {

std::string DescribeFloor(const MapFrame& frame);

// Why z may not be up, with both directions that fit; empty if there is no doubt.
std::string UpWarning(const MapFrame& frame);

// Reasons why z = 0 may not be the floor; empty if there are none.
std::vector<std::string> FloorWarnings(const MapFrame& frame);

// Logs the floor and all warnings.
void LogFloor(const MapFrame& frame);

// The stage's report.
nlohmann::json Summarize(const MapFrame& frame);

}  // namespace nightmap
