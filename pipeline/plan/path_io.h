// SPDX-License-Identifier: Apache-2.0
// A path written by the plan stage, for the stages that drive it.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <vector>

namespace nightmap {

struct PlannedPath {
  // One leg per goal, in order; each with its first to last point, at least one. A leg starts where
  // the previous one ends.
  std::vector<std::vector<Eigen::Vector2d>> legs_in_map;
  double goal_heading_rad = 0;  // counter-clockwise from x, at the last point
  // Radius of the circle around the whole robot for which it was planned.
  double robot_radius_m = 0;
  bool may_cross_unknown = false;
  double max_hole_m = 0;  // width of holes that it may cross, see unknown_holes.h
  int floor = 0;          // FloorFiles::number of its floor
};

// Reads path.csv (columns x_m,y_m,heading_rad,distance_m,leg_idx, then any others) and the
// path.json that was written with it. Throws DataError naming file and line or field on another
// format or version, a wrong header, NaN, a heading that is no angle, no point, legs out of order
// or without length, or when the number of points or legs or the length differs from the JSON's.
PlannedPath ReadPlannedPath(const std::filesystem::path& csv_path,
                            const std::filesystem::path& json_path);

}  // namespace nightmap
