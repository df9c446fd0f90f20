// SPDX-License-Identifier: Apache-2.0
// Where a round robot collides on the grid.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "pipeline/io/grid_io.h"

namespace nightmap {

struct Footprint {
  double radius_m = 0;
  bool unknown_is_obstacle = true;  // and everything outside of the grid
};

// Clearance is the distance from a point to the nearest obstacle cell, which is taken as the whole
// square: what is seen in a cell may be anywhere in it. A robot whose clearance is less than its
// radius collides.
class ClearanceMap {
 public:
  static constexpr double kFar_m = 1.0;

  ClearanceMap(const OccupancyGrid& grid, const Footprint& footprint);

  // 0 inside of an obstacle. Exact below kFar_m; from there on at most the true one, and at least
  // kFar_m.
  double Clearance_m(const Eigen::Vector2d& point_in_map) const;
  // No collision, and some more room.
  bool IsClear(const Eigen::Vector2d& point_in_map, double margin_m = 0) const;
  // The smallest clearance without a collision: the radius, less what rounding to the micrometres
  // of a file does to a path that keeps it exactly.
  double MinClearance_m() const { return min_clearance_m_; }

 private:
  bool IsObstacle(const Eigen::Vector2i& cell) const;
  // What the clearance lies between, for a point in cells; in cells.
  std::pair<double, double> Bounds(const Eigen::Vector2d& point) const;

  OccupancyGrid grid_;
  Footprint footprint_;
  double min_clearance_m_ = 0;
  std::vector<float> distances_;  // cells, to the nearest obstacle cell, centre to centre
};

}  // namespace nightmap
