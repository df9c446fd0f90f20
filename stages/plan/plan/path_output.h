// SPDX-License-Identifier: Apache-2.0
// The plan stage's artifacts: path.csv, path.json, path.yaml and path.png.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "pipeline/io/image_io.h"
#include "stages/plan/plan/plan.h"

namespace nightmap {

// Header x_m,y_m,heading_rad,distance_m,leg_idx,clearance_m,z_m,floor; map frame, one row per path
// point. Every row has the height and the number of the floor.
std::string PathToCsv(const PlanResult& result);

// ROS's nav_msgs/Path as `ros2 topic echo` prints it and `ros2 topic pub` takes it: frame `map`,
// one pose per path point, at the floor's height, rotated about z by its heading. Stamps are zero.
std::string PathToNavYaml(const PlanResult& result);

// The path's figures, its ends and legs, for report.json.
nlohmann::ordered_json PathFigures(const PlanResult& result);

// Format nightmap_path, version 3: the floor, the figures, ends as requested and as used (with the
// rectangle of an object or a thing), legs, the config.
nlohmann::ordered_json PathToJson(const PlanResult& result, const std::string& config_toml);

// Says where the path is, how far its ends were moved, and what is narrow on it.
void LogPlan(const PlanOptions& options, const PlanResult& result);

// Draws the grid (white free, black occupied, grey unknown, pale green dots in unknown cells that
// count as free), this floor's trajectory in a faint color, the swath of the robot's circle, the
// path, orange where it is narrow, every end (with the robot's outline if it is a polygon, and the
// rectangle of an object or a thing) and a scale bar; y up. Names the floor if there are several.
// Enlarged by PixelsPerCell.
ColorImage DrawPath(const PlanOptions& options, const PlanInputs& inputs, const PlanResult& result);

// The integer factor of a floor's pictures.
int PixelsPerCell(const OccupancyGrid& grid);

}  // namespace nightmap
