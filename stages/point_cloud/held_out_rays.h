// SPDX-License-Identifier: Apache-2.0
// A quality figure that needs no truth: rays that some keyframes measured against the cloud that
// the others made. Keyframes are in five folds by turns; a voxel of the cloud counts for a ray only
// when a keyframe of another fold has measured it too (so every keyframe is held out once, and no
// cloud is made twice: Stone, Cross-validatory choice and assessment of statistical predictions,
// 1974).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "stages/point_cloud/voxel_filter.h"

namespace nightmap {

constexpr int kNumFolds = 5;

// A measurement that passed the depth filter, in the map frame.
struct HeldOutRay {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d end = Eigen::Vector3d::Zero();
  double tolerance_m = 0;  // by which the end may be off the surface
  std::uint8_t fold = 0;   // one bit, as in VoxelSum::folds
};

struct RayAgreement {
  std::size_t num_rays = 0;
  std::size_t num_agreeing = 0;  // end on the cloud and pass nothing before it
  std::size_t num_blocked = 0;   // pass a surface of the cloud; the rest end where there is none
};

// A ray is blocked by a point less than half a voxel beside it, when its end lies behind that
// point's plane by more than the tolerance; it agrees when a point in the voxels about its end has
// its plane within the tolerance of the end. `cloud` has normals for directions. What lies outside
// the cloud blocks nothing. Same result at any number of threads.
RayAgreement TestRays(const std::vector<HeldOutRay>& rays,
                      const VoxelSums& cloud,
                      double voxel_size_m,
                      int num_threads);

}  // namespace nightmap
