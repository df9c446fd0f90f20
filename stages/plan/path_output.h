// SPDX-License-Identifier: Apache-2.0
// The plan stage's artifacts: path.csv, path.json and path.png.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "pipeline/io/image_io.h"
#include "stages/plan/plan.h"

namespace nightmap {

// Header x_m,y_m,heading_rad,distance_m; map frame, one row a path point.
std::string PathToCsv(const PlanResult& result);

// The path's figures and both ends, for report.json.
nlohmann::ordered_json PathFigures(const PlanResult& result);

// Format nightmap_path, version 1: the figures, both ends as asked for and as used, the config.
nlohmann::ordered_json PathToJson(const PlanResult& result, const std::string& config_toml);

// The grid (white free, black occupied, grey unknown) with the trajectory faint, the swath of the
// robot, the path, both ends and a scale bar; y up. Enlarged by a whole factor.
ColorImage DrawPath(const PlanInputs& inputs, const PlanResult& result, double robot_radius_m);

}  // namespace nightmap
