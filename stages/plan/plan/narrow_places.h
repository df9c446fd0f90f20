// SPDX-License-Identifier: Apache-2.0
// Where a planned path has less room than its robot needs on a drive.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace nightmap {

struct PathPoint {
  Eigen::Vector2d point_in_map = Eigen::Vector2d::Zero();
  // Counter-clockwise from x; onward direction. The last point's faces the thing that the path ends
  // at, else it is as before.
  double heading_rad = 0;
  double distance_m = 0;   // along the path
  int leg_idx = 0;         // leg that the point lies on or ends
  double clearance_m = 0;  // of the point's cell, see CostMap
};

// Successive points of a path.
struct NarrowPlace {
  std::size_t first_point = 0;
  std::size_t last_point = 0;
  double length_m = 0;
  Eigen::Vector2d narrowest_in_map = Eigen::Vector2d::Zero();  // the first such point
  double room_m = 0;  // there, between the robot's circle and the nearest obstacle
};

// Stretches of the path, in order, on which the robot's circle is less than `margin_m` from an
// obstacle.
std::vector<NarrowPlace> FindNarrowPlaces(const std::vector<PathPoint>& path,
                                          double robot_radius_m,
                                          double margin_m);

}  // namespace nightmap
