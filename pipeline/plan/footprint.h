// SPDX-License-Identifier: Apache-2.0
// The robot's footprint.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/base/options.h"

namespace nightmap {

// Robot's frame: x forward, y left, origin at the centre about which it turns.
struct FootprintOptions {
  OPTION(double, robot_radius_m, 0.25, {0.0, 5.0}, "radius of a round robot");
  OPTION(std::vector<double>, footprint_m, std::vector<double>(), {-5.0, 5.0},
         "corners x0, y0, x1, y1, ... of a polygonal robot, x forward, turning about 0, 0; "
         "overrides robot_radius_m");
  REGISTER_OPTIONS();
};

// The corners of the polygon, or none for a round robot. Throws UsageError unless there are three
// or more pairs of numbers.
std::vector<Eigen::Vector2d> FootprintCorners(const FootprintOptions& options);

// Radius of the circle around the robot's centre that contains it at any heading. A path is planned
// for this circle, so the robot may take any heading anywhere on the path, and the path avoids gaps
// that it would fit only lengthwise.
double CircumscribedRadius_m(const FootprintOptions& options);

}  // namespace nightmap
