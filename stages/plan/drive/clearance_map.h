// SPDX-License-Identifier: Apache-2.0
// The room of a round robot on a grid.
#pragma once

#include <Eigen/Core>

#include "pipeline/io/grid_io.h"
#include "pipeline/plan/obstacle_distances.h"
#include "pipeline/plan/unknown_holes.h"

namespace nightmap {

struct Footprint {
  double radius_m = 0;
  bool unknown_is_obstacle = true;  // so is everything outside the grid
  double max_hole_m = 0;            // but see FindUnknownHoles
};

// Points are in the map. Clearance is the distance to the nearest obstacle, see ObstacleDistances;
// room is what of it is beside the robot.
class ClearanceMap {
 public:
  ClearanceMap(const OccupancyGrid& grid, const Footprint& footprint)
      : grid_(WithHolesFree(grid, footprint.max_hole_m)),
        distances_(grid_, footprint.unknown_is_obstacle, 1),
        radius_m_(footprint.radius_m) {}

  double Clearance_m(const Eigen::Vector2d& point_in_map) const {
    return distances_.Clearance_m(grid_.ToCells(point_in_map));
  }
  // Whether the robot keeps at least `room_m` to every obstacle; with none it collides.
  bool IsClear(const Eigen::Vector2d& point_in_map, double room_m = 0) const {
    return distances_.Fits(grid_.ToCells(point_in_map), radius_m_ + room_m);
  }
  double Room_m(const Eigen::Vector2d& point_in_map) const {
    return Clearance_m(point_in_map) - (radius_m_ - ObstacleDistances::kFileRounding_m);
  }

 private:
  OccupancyGrid grid_;  // with holes free
  ObstacleDistances distances_;
  double radius_m_;
};

}  // namespace nightmap
