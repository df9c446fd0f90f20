// SPDX-License-Identifier: Apache-2.0
// Free space that is connected to the camera's path.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/io/grid_io.h"

namespace nightmap {

// For each cell, whether a camera was within `reach_m` of it and at most `max_camera_height_m`
// above the ground of its own cell. A person who carries a camera fits there, and so does a robot.
std::vector<bool> CellsAroundCameras(const std::vector<Eigen::Vector3d>& cameras_in_map,
                                     const std::vector<double>& ground_m,
                                     double max_camera_height_m,
                                     double reach_m,
                                     const OccupancyGrid& grid);

// Makes free cells unknown unless a chain of free cells (4 neighbours) joins them to the free cell
// nearest to some camera. The free cell must be within a metre of the camera. Cameras more than
// `max_camera_height_m` above the ground of their cell do not count. Without any counted camera
// nothing changes. Returns how many cells became unknown.
std::size_t RemoveUnvisited(const std::vector<Eigen::Vector3d>& cameras_in_map,
                            const std::vector<double>& ground_m,
                            double max_camera_height_m,
                            OccupancyGrid& grid);

}  // namespace nightmap
