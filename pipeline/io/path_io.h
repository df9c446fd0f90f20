// SPDX-License-Identifier: Apache-2.0
// A path that the plan stage wrote, for those who drive it.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <vector>

namespace nightmap {

struct PlannedPath {
  std::vector<Eigen::Vector2d> points_in_map;  // start to goal, at least one
  double goal_heading_rad = 0;                 // counter-clockwise from x, of the last point
  // What it was planned for, as far as path.json says so.
  std::optional<double> robot_radius_m;
  bool may_cross_unknown = false;
};

// path.csv (columns x_m,y_m,heading_rad,distance_m, and any after them) and the path.json that was
// written with it. Throws DataError naming file and line or field: another format, a newer version,
// a wrong header, NaN, no point, or a number of points other than the JSON's.
PlannedPath ReadPlannedPath(const std::filesystem::path& csv_path,
                            const std::filesystem::path& json_path);

}  // namespace nightmap
