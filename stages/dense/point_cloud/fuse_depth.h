// SPDX-License-Identifier: Apache-2.0
// Averages the depth of all keyframes by voxel.
#pragma once

#include <string>
#include <vector>

#include "stages/dense/point_cloud/point_cloud.h"
#include "stages/dense/point_cloud/voxel_filter.h"

namespace nightmap {

struct FusedDepth {
  VoxelSums sums;                // of the region and its overlap
  std::vector<HeldOutRay> rays;  // samples of each keyframe's rays that end in the region
  std::vector<std::string> skipped;
};

// Largest depth difference at which two measurements still count as the same surface: depth noise
// plus a voxel for everything else.
double DepthTolerance_m(const PointCloudOptions& options, double sigma_m);

// Points weigh 1 / sigma^2 of the depth noise. Same result at any number of threads.
FusedDepth FuseDepth(const PointCloudOptions& options,
                     const KeyframeSource& source,
                     Progress& progress,
                     int num_threads);

}  // namespace nightmap
