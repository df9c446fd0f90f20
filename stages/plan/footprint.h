// SPDX-License-Identifier: Apache-2.0
// The ground a robot covers, and whether it stands clear of obstacles.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/io/grid_io.h"

namespace nightmap {

// In the robot's frame: x forward, y left, the centre that it turns about at the origin.
struct FootprintOptions {
  double robot_radius_m = 0.25;  // of a round robot
  std::vector<double>
      footprint_m;  // x and y of each corner of a polygon; empty: the robot is round

  void Register(OptionList& list);
};

// The corners of the polygon, none for a round robot. Throws UsageError unless they are three or
// more pairs of numbers.
std::vector<Eigen::Vector2d> FootprintCorners(const FootprintOptions& options);

// Radius of the circle about the robot's centre that it stays in however it turns. A path is
// planned for this circle: the robot may take any heading anywhere on it, and does not pass where
// it would fit only lengthwise.
double CircumscribedRadius_m(const FootprintOptions& options);

// Whether a circle about a point touches no cell that is an obstacle, nor, where the unknown is
// one, reaches beyond the grid. Exact but for rounding.
bool IsCircleClear(const OccupancyGrid& grid,
                   const Eigen::Vector2d& centre_in_map,
                   double radius_m,
                   bool unknown_is_obstacle);

}  // namespace nightmap
