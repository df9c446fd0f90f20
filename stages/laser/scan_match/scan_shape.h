// SPDX-License-Identifier: Apache-2.0
// Shape of a scan: points, and the walls that they lie on.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/recording/scan_points.h"
#include "stages/laser/scan_match/scan_match.h"

namespace nightmap {

struct ScanShape {
  std::vector<Eigen::Vector2d> points;   // one per cell: many beams on a wall nearby say no more
  std::vector<Eigen::Vector2d> normals;  // of the walls of these points (wall_normals.h)
};

// Shape of the points within max_range_m, in the robot's axes. Pure.
ScanShape ShapeOf(const ScanMatchOptions& options, const ScanPoints& scan);

}  // namespace nightmap
