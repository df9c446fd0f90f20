// SPDX-License-Identifier: Apache-2.0
// A quality figure that needs no ground truth: tests rays of some keyframes against the cloud of
// the others. Keyframes are divided into five folds by turns. A voxel of the cloud counts for a ray
// only when a keyframe of another fold has measured it too. So every keyframe is held out once, and
// no cloud is made twice (cross-validation: Stone, Cross-validatory choice and assessment of
// statistical predictions, 1974).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "stages/dense/point_cloud/voxel_filter.h"

namespace nightmap {

constexpr int kNumFolds = 5;

// A measurement that passed the depth filter, in the map frame.
struct HeldOutRay {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d end = Eigen::Vector3d::Zero();
  double tolerance_m = 0;  // largest distance of the end from its surface
  std::uint8_t fold = 0;   // one bit, see VoxelSum::folds
};

enum class RayEnd : std::uint8_t {
  kOnTheCloud,  // and the ray passes nothing before it
  kBlocked,     // the ray passes through a surface of the cloud
  kNowhere,     // where the cloud has no surface
};

struct RayAgreement {
  std::size_t num_rays = 0;
  std::size_t num_agreeing = 0;  // kOnTheCloud
  std::size_t num_blocked = 0;
};

// A ray is blocked by a point less than half a voxel beside it, when the ray's end lies behind that
// point's plane by more than the tolerance. It agrees when a point in the voxels around its end has
// a plane within the tolerance of the end. `cloud` has normals as directions. Nothing blocks
// outside the cloud. Same result at any number of threads.
std::vector<RayEnd> TestRays(const std::vector<HeldOutRay>& rays,
                             const VoxelSums& cloud,
                             double voxel_size_m,
                             int num_threads);

RayAgreement AgreementOf(const std::vector<RayEnd>& ends);

}  // namespace nightmap
