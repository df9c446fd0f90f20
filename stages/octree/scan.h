// SPDX-License-Identifier: Apache-2.0
// What one depth image says about the voxels: hit where a ray ends, passed where one goes through.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/geometry/voxel_key.h"
#include "stages/octree/block_colors.h"
#include "stages/octree/voxel_block.h"

namespace nightmap {

// One measured point and how far before it space is not declared free.
struct ScanPoint {
  Eigen::Vector3d point_in_map = Eigen::Vector3d::Zero();
  double margin_m = 0;
  std::array<std::uint8_t, 3> rgb{};
};

struct Scan {
  Eigen::Vector3d origin_in_map = Eigen::Vector3d::Zero();
  std::vector<ScanPoint> points;
};

struct ScanOptions {
  double resolution_m = 0.05;
  double max_range_m = 4.0;
  bool discretize = true;
  std::optional<VoxelBox> region;
};

struct BlockEvidence {
  BlockBits hit;
  BlockBits passed;               // never where hit
  std::uint32_t first_color = 0;  // into the scan's colors, one for each hit in order
};

struct ScanEvidence {
  std::vector<BlockMap<BlockEvidence>::Entry> blocks;  // in ascending order
  std::vector<ColorSum> colors;
  std::size_t num_rays = 0;  // cast, after merging
};

// A voxel is hit when a point lies in it, else passed when a ray from a point to the origin goes
// through it, the one in which the ray begins (margin_m before the point) left out. So a voxel has
// at most one of the two, however many points and rays it holds, and hit beats passed, which keeps
// surfaces seen at a low angle: OctoMap's computeUpdate (Hornung et al. 2013). With `discretize`
// the points of a voxel share one ray, from their mean. Points beyond max_range_m only free the
// space up to it, with `discretize` one of those cut in one voxel. Of all this, what is outside
// `region` is dropped; none: nothing is. Points and origin must lie within OctreeReach_m.
ScanEvidence TraceScan(const Scan& scan, const ScanOptions& options);

}  // namespace nightmap
