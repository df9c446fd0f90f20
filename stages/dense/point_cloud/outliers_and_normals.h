// SPDX-License-Identifier: Apache-2.0
// Turns points into a surface: removes outliers, fits normals, measures thickness.
#pragma once

#include <vector>

#include "stages/dense/point_cloud/voxel_filter.h"

namespace nightmap {

// Drops points with fewer than `min_neighbors` others within `radius_m`. The decision on a point
// depends on its neighbourhood alone, so a cloud made in parts loses the same points.
SortedVoxels RemoveOutliers(const SortedVoxels& voxels,
                            double voxel_size_m,
                            double radius_m,
                            int min_neighbors,
                            int num_threads);

struct Surface {
  // The input points; `direction` is replaced by the unit normal that faces the cameras.
  std::vector<VoxelSum> points;
  // For each point, the standard deviation (metres) of its neighbours from their plane, before they
  // are moved; negative where they are not flat. It grows with the depth noise and, where a wall
  // was mapped twice, with the distance of the copies. Its square is the plane variance of Razlaw,
  // Droeschel, Holz, Behnke, Evaluation of registration methods for sparse 3D laser scans, 2015.
  std::vector<float> thickness_m;
};

// Fits a plane to the points within `radius_m` of each point, weighted by certainty and closeness
// (one projection of moving least squares: Alexa et al., Computing and rendering point set
// surfaces, 2003). Where the neighbourhood is flat and `project` is set, moves the point along the
// normal onto the plane, by less than `radius_m`. Same result at any number of threads.
Surface FitSurface(const SortedVoxels& voxels,
                   double voxel_size_m,
                   double radius_m,
                   bool project,
                   int num_threads);

}  // namespace nightmap
