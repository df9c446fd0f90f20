// SPDX-License-Identifier: Apache-2.0
// A path that the plan stage wrote, for those who drive it.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace nightmap {

struct PlannedPath {
  // A leg ends at each goal in turn; from its first to its last point, at least one. A leg starts
  // where the one before it ends.
  std::vector<std::vector<Eigen::Vector2d>> legs_in_map;
  double goal_heading_rad = 0;  // counter-clockwise from x, of the last point
  double robot_radius_m = 0;    // for which it was planned: of a circle about all of the robot
  bool may_cross_unknown = false;
  int floor = 0;                    // FloorFiles::number of the floor that it is on
  std::string source = "path.csv";  // its file, for messages
};

// path.csv (columns x_m,y_m,heading_rad,distance_m,leg_idx, and any after them) and the path.json
// that was written with it. Throws DataError naming file and line or field: another format or
// version, a wrong header, NaN, a heading that is no angle, no point, legs out of order or without
// length, or a number of points or legs or a length other than the JSON's.
PlannedPath ReadPlannedPath(const std::filesystem::path& csv_path,
                            const std::filesystem::path& json_path);

}  // namespace nightmap
