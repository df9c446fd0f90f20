// SPDX-License-Identifier: Apache-2.0
// What one depth image says about the voxels: hit where a ray ends, free where it passes.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "stages/octree/voxel_block.h"

namespace nightmap {

// One measured point and how far before it space is not declared free.
struct ScanPoint {
  Eigen::Vector3d point_in_map;
  double margin_m = 0;
  std::array<std::uint8_t, 3> rgb{};
};

struct ScanOptions {
  double resolution_m = 0.05;
  double max_range_m = 4.0;
  bool discretize = true;
};

struct ColorSum {
  std::array<std::uint32_t, 3> rgb{};
  std::uint32_t count = 0;
};

struct BlockEvidence {
  BlockBits hit;
  BlockBits passed;  // never where hit
};

struct HitColor {
  VoxelKey voxel;
  ColorSum color;
};

struct ScanEvidence {
  BlockMap<BlockEvidence> blocks;
  std::vector<HitColor> colors;     // one entry a hit voxel
  std::size_t num_rays = 0;         // cast, after merging
  std::size_t num_unsupported = 0;  // points in range that `support` refused
};

// The voxels that may become occupied. Null means all.
using VoxelSupport = BlockMap<BlockBits>;

// Casts rays from `origin` through the grid (Amanatides and Woo, A fast voxel traversal algorithm
// for ray tracing, 1987). A voxel that is hit is not passed as well, which keeps surfaces seen at a
// low angle. With `discretize` the points of a voxel share one ray, to their mean. Points beyond
// max_range_m only free the space up to it. Points outside `support` count for nothing.
ScanEvidence TraceScan(const Eigen::Vector3d& origin,
                       const std::vector<ScanPoint>& points,
                       const ScanOptions& options,
                       const VoxelSupport* support);

}  // namespace nightmap
