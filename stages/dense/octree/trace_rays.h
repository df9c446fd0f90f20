// SPDX-License-Identifier: Apache-2.0
// Evidence of one keyframe's rays about voxels: hit where a ray ends, passed where a ray goes
// through.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/geometry/voxel_key.h"
#include "stages/dense/octree/block_colors.h"
#include "stages/dense/octree/voxel_block.h"

namespace nightmap {

// A measured point, and the distance in front of it in which space is not declared free.
struct RayEnd {
  Eigen::Vector3d point_in_map = Eigen::Vector3d::Zero();
  double margin_m = 0;
  std::array<std::uint8_t, 3> rgb{};
};

struct KeyframeRays {
  Eigen::Vector3d origin_in_map = Eigen::Vector3d::Zero();
  std::vector<RayEnd> points;
};

struct TraceOptions {
  double resolution_m = 0.05;
  double max_range_m = 4.0;
  bool discretize = true;
  std::optional<VoxelBox> region;
};

struct BlockEvidence {
  BlockBits hit;
  BlockBits passed;  // never where hit
  // Index into the keyframe's colors, which hold one for each hit in order.
  std::uint32_t first_color = 0;
};

struct KeyframeEvidence {
  std::vector<BlockMap<BlockEvidence>::Entry> blocks;  // in ascending order
  std::vector<ColorSum> colors;
  std::size_t num_rays = 0;  // rays cast, after merging
};

// A voxel is hit when a point lies in it. Otherwise it is passed when a ray from a point to the
// origin goes through it; the voxel in which the ray begins (margin_m before the point) is left
// out. So a voxel gets at most one of the two, however many points and rays it holds. A hit beats a
// pass, which keeps surfaces seen at a low angle: OctoMap's computeUpdate (Hornung et al. 2013).
// With `discretize` the points of a voxel share one ray, from their mean. Points beyond max_range_m
// only free the space up to that range; with `discretize` one ray per voxel in which such rays are
// cut. Evidence outside `region` is dropped; without a region none is. Points and origin must lie
// within OctreeReach_m.
KeyframeEvidence TraceRays(const KeyframeRays& rays, const TraceOptions& options);

}  // namespace nightmap
