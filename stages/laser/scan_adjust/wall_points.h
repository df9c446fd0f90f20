// SPDX-License-Identifier: Apache-2.0
// Points of a scan that lie on a wall, with the direction that the wall faces.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace nightmap {

struct WallPoint {
  Eigen::Vector2d point_in_robot;   // metres
  Eigen::Vector2d normal_in_robot;  // unit, towards the robot
};

// The points whose neighbours in the order of the beams lie on a line with them, at least spacing_m
// apart. Pure.
std::vector<WallPoint> FindWallPoints(const std::vector<Eigen::Vector2d>& points_in_robot,
                                      double spacing_m);

}  // namespace nightmap
