// SPDX-License-Identifier: Apache-2.0
// Where a robot could stand, and the floors of the building among these places. A column may hold
// several places, one above the other (a multi-level surface map: Triebel, Pfaff and Burgard, IROS
// 2006).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "stages/grid/columns.h"
#include "stages/grid/grid.h"

namespace nightmap {

// The highest voxels of the surfaces with seen free space right above and nothing occupied up to
// the robot's height, not counting a step.
struct Supports {
  std::vector<std::size_t> first;  // of each column; and the end
  std::vector<int> tops;           // voxels, upwards in a column

  std::span<const int> Of(std::size_t column) const {
    return {tops.data() + first[column], tops.data() + first[column + 1]};
  }
};

// A camera this far above a floor, or less, is on it.
constexpr double kMaxCameraHeight_m = 2.5;

// A surface is taken to be in the middle of its voxel.
inline double SurfaceHeight_m(int top, double resolution_m) { return (top + 0.5) * resolution_m; }

Supports FindSupports(const GridOptions& options, const Columns& columns);

// Heights of the floors, rising. One is 0: map_frame put the map's floor there. Others are the
// heights with the most supports, at least min_floor_area_m2 of them and min_floor_distance_m from
// every floor that has more, over which a camera was (unless `cameras_in_map` is empty). So the top
// of a table is no floor: it is too near to one.
std::vector<double> FindFloors(const GridOptions& options,
                               const Columns& columns,
                               const Supports& supports,
                               const std::vector<Eigen::Vector3d>& cameras_in_map);

}  // namespace nightmap
