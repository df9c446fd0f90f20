// SPDX-License-Identifier: Apache-2.0
// The depth of all keyframes, averaged by voxel.
#pragma once

#include <string>
#include <vector>

#include "stages/point_cloud/point_cloud.h"
#include "stages/point_cloud/voxel_filter.h"

namespace nightmap {

struct FusedDepth {
  VoxelSums sums;                // of the region with its overlap
  std::vector<HeldOutRay> rays;  // drawn from each keyframe's, those that end in the region
  std::vector<std::string> skipped;
};

// How far a depth may be off that is still the same surface: noise, and a voxel for what is none.
double DepthTolerance_m(const PointCloudOptions& options, double sigma_m);

// Points weigh 1 / sigma^2 of the depth noise. Same result at any number of threads.
FusedDepth FuseDepth(const PointCloudOptions& options,
                     const KeyframeSource& source,
                     Progress& progress,
                     int num_threads);

}  // namespace nightmap
