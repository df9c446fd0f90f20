// SPDX-License-Identifier: Apache-2.0
// States of octrees voxel by voxel, for comparison.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "pipeline/dense/octree_io.h"
#include "pipeline/geometry/voxel_key.h"
#include "stages/dense/octree/voxel_block.h"

namespace nightmap {

// Calls visit(code, occupied) for every voxel of the smallest size.
template <typename Visit>
void ForVoxels(const OccupancyTree& tree, const Visit& visit) {
  for (const OccupancyVoxel& leaf : tree.leaves) {
    const auto edge = static_cast<std::uint64_t>(std::lround(leaf.size_m / tree.resolution_m));
    const Eigen::Vector3d first_centre =
        leaf.centre_in_map.array() - (leaf.size_m - tree.resolution_m) / 2;
    const std::uint64_t first = MortonCode(VoxelOf(first_centre, tree.resolution_m));
    for (std::uint64_t code = first; code < first + edge * edge * edge; ++code) {
      visit(code, leaf.Occupied());
    }
  }
}

class VoxelStates {
 public:
  explicit VoxelStates(const OccupancyTree& tree) {
    ForVoxels(tree, [this](std::uint64_t code, bool occupied) {
      blocks_.At(BlockOf(code))[occupied ? 1 : 0].Set(IndexInBlock(code));
    });
  }

  bool Is(std::uint64_t code, bool occupied) const {
    const auto* block = blocks_.Find(BlockOf(code));
    return block != nullptr && (*block)[occupied ? 1 : 0].Test(IndexInBlock(code));
  }

  std::size_t Count(bool occupied) const {
    std::size_t count = 0;
    for (const auto& entry : blocks_.Entries()) count += entry.value[occupied ? 1 : 0].Count();
    return count;
  }

  // Share of the voxels occupied (or free) in either tree that are so in both.
  double IntersectionOverUnion(const VoxelStates& other, bool occupied) const {
    std::size_t num_both = 0;
    for (const auto& entry : blocks_.Entries()) {
      const auto* block = other.blocks_.Find(entry.block);
      if (block == nullptr) continue;
      BlockBits both = entry.value[occupied ? 1 : 0];
      both &= (*block)[occupied ? 1 : 0];
      num_both += both.Count();
    }
    const std::size_t num_any = Count(occupied) + other.Count(occupied) - num_both;
    return static_cast<double>(num_both) / static_cast<double>(num_any);
  }

 private:
  BlockMap<std::array<BlockBits, 2>> blocks_;  // free, occupied
};

}  // namespace nightmap
