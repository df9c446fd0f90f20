// SPDX-License-Identifier: Apache-2.0
// Points to surface: outliers, normals, and thickness.
#pragma once

#include <vector>

#include "stages/point_cloud/voxel_filter.h"

namespace nightmap {

// Drops points whose mean distance to their `num_neighbors` nearest exceeds the mean of all points
// by `max_deviations` standard deviations (Rusu et al., Towards 3D point cloud based object maps,
// 2008).
std::vector<VoxelSum> RemoveOutliers(const std::vector<VoxelSum>& points,
                                     int num_neighbors,
                                     double max_deviations);

// Fits a plane to the points within `radius_m` of each point, weighted by their certainty and
// closeness (one projection of moving least squares: Alexa et al., Computing and rendering point
// set surfaces, 2003). Returns the points with `direction` replaced by the unit normal on the side
// of the cameras and, where the neighbourhood is flat and `project` is set, moved along it onto the
// plane. Same result at any number of threads.
std::vector<VoxelSum> FitSurface(const std::vector<VoxelSum>& points,
                                 double radius_m,
                                 bool project,
                                 int num_threads);

}  // namespace nightmap
