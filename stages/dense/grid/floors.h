// SPDX-License-Identifier: Apache-2.0
// Surfaces on which a robot could stand, and the floors of the building among them. A column may
// hold several surfaces, one above the other (multi-level surface map: Triebel, Pfaff and Burgard,
// IROS 2006).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "stages/dense/grid/columns.h"
#include "stages/dense/grid/grid.h"

namespace nightmap {

// The top voxels of surfaces that have seen free space right above them and, apart from the height
// of one step, nothing occupied up to the robot's height.
struct Supports {
  std::vector<std::size_t> first;  // index of each column's first top; then the end
  std::vector<int> tops;           // voxels, upwards in a column

  std::span<const int> Of(std::size_t column) const {
    return {tops.data() + first[column], tops.data() + first[column + 1]};
  }
};

// A camera at most this far above a floor is on that floor.
constexpr double kMaxCameraHeight_m = 2.5;

// A surface is assumed to be in the middle of its voxel.
inline double SurfaceHeight_m(int top, double resolution_m) { return (top + 0.5) * resolution_m; }

Supports FindSupports(const GridOptions& options, const Columns& columns);

// Heights of the floors, ascending. One is 0, because map_frame put the map's floor there. The
// others are the heights with the most supports. Each has at least 3 m2 of them, is at least 2 m
// from every floor that has more, and had a camera above it (not required if `cameras_in_map` is
// empty). A table top is no floor, because it is too near to one.
std::vector<double> FindFloors(const Columns& columns,
                               const Supports& supports,
                               const std::vector<Eigen::Vector3d>& cameras_in_map);

}  // namespace nightmap
