// SPDX-License-Identifier: Apache-2.0
// Free space that the camera's way leads to.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/io/grid_io.h"

namespace nightmap {

// For each cell, whether a camera was within `reach_m` of it and at most `max_camera_height_m`
// above the ground of its own cell: who carries a camera stands there, and a robot even more so.
std::vector<bool> CellsAroundCameras(const std::vector<Eigen::Vector3d>& cameras_in_map,
                                     const std::vector<double>& ground_m,
                                     double max_camera_height_m,
                                     double reach_m,
                                     const OccupancyGrid& grid);

// Makes free cells unknown that no chain of free cells (4 neighbours) joins to the one nearest to a
// camera, up to a metre off and counted over the cameras at most `max_camera_height_m` above the
// ground of their cell. Without such a camera nothing changes. Returns how many cells became
// unknown.
std::size_t RemoveUnvisited(const std::vector<Eigen::Vector3d>& cameras_in_map,
                            const std::vector<double>& ground_m,
                            double max_camera_height_m,
                            OccupancyGrid& grid);

}  // namespace nightmap
