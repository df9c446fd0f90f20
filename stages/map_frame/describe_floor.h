// SPDX-License-Identifier: Apache-2.0
// What z = 0 is, in words: for the log, report.json and the report page.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "stages/map_frame/map_frame.h"

namespace nightmap {

std::string DescribeFloor(const MapFrame& frame);

// Why z = 0 may not be the floor; empty where nothing says so.
std::vector<std::string> FloorWarnings(const MapFrame& frame);

// Both, to the log.
void LogFloor(const MapFrame& frame);

// The stage's report.
nlohmann::json Summarize(const MapFrame& frame);

}  // namespace nightmap
