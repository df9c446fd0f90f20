// SPDX-License-Identifier: Apache-2.0
// Distance from a round robot's centre to the obstacles of the grid.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "pipeline/io/grid_io.h"

namespace nightmap {

struct Footprint {
  double radius_m = 0;
  bool unknown_is_obstacle = true;  // so is everything outside the grid
  double max_hole_m = 0;            // but see FindUnknownHoles
};

// Clearance is the distance from a point to the nearest obstacle cell. The whole cell counts as
// obstacle, because the thing seen in it may be anywhere in it. A robot whose clearance is less
// than its radius collides.
class ClearanceMap {
 public:
  static constexpr double kFar_m = 1.0;

  ClearanceMap(const OccupancyGrid& grid, const Footprint& footprint);

  // 0 inside an obstacle. Exact below kFar_m; beyond, a lower bound that is at least kFar_m.
  double Clearance_m(const Eigen::Vector2d& point_in_map) const;
  // Whether the robot keeps at least `margin_m` of room to every obstacle.
  bool IsClear(const Eigen::Vector2d& point_in_map, double margin_m = 0) const;
  // The smallest clearance without a collision: the radius less a rounding tolerance. Files round
  // to micrometres, so a path at exactly the radius would otherwise collide.
  double MinClearance_m() const { return min_clearance_m_; }

 private:
  bool IsObstacle(const Eigen::Vector2i& cell) const;
  // Lower and upper bound of the clearance of a point; point and bounds in cells.
  std::pair<double, double> Bounds(const Eigen::Vector2d& point) const;

  OccupancyGrid grid_;
  Footprint footprint_;
  double min_clearance_m_ = 0;
  std::vector<float> distances_;  // cells, from cell centre to the nearest obstacle's centre
};

}  // namespace nightmap
