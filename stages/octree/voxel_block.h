// SPDX-License-Identifier: Apache-2.0
// Voxels of the smallest size in blocks of 8 x 8 x 8, so that a ray or a neighbourhood stays mostly
// within one hash entry.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <unordered_map>

#include "pipeline/geometry/voxel_key.h"

namespace nightmap {

constexpr int kBlockEdge = 8;
constexpr int kBlockVoxels = kBlockEdge * kBlockEdge * kBlockEdge;
using BlockBits = std::bitset<kBlockVoxels>;

// Arithmetic shift: rounds down for negative keys too, so blocks coincide with octree nodes.
inline VoxelKey BlockOf(const VoxelKey& voxel) {
  return {voxel.x() >> 3, voxel.y() >> 3, voxel.z() >> 3};
}

inline std::size_t IndexInBlock(const VoxelKey& voxel) {
  return static_cast<std::size_t>((voxel.x() & 7) << 6 | (voxel.y() & 7) << 3 | (voxel.z() & 7));
}

inline VoxelKey VoxelInBlock(const VoxelKey& block, std::size_t index) {
  const int i = static_cast<int>(index);
  return block * kBlockEdge + VoxelKey(i >> 6, i >> 3 & 7, i & 7);
}

// Indices in a block in the order of an octree's leaves.
constexpr std::array<std::size_t, kBlockVoxels> MortonOrderInBlock() {
  std::array<std::size_t, kBlockVoxels> order{};
  for (std::size_t code = 0; code < kBlockVoxels; ++code) {
    const auto every_third = [](std::size_t bits) {
      return (bits & 1) | (bits >> 2 & 2) | (bits >> 4 & 4);
    };
    order[code] = every_third(code) << 6 | every_third(code >> 1) << 3 | every_third(code >> 2);
  }
  return order;
}

// Values of type T by block, made when first asked for. Remembers the last block: neighbouring
// calls are cheap. Not for use from two threads at once.
template <typename T>
class BlockMap {
 public:
  BlockMap() = default;
  BlockMap(BlockMap&&) noexcept = default;
  BlockMap& operator=(BlockMap&&) noexcept = default;

  T& At(const VoxelKey& block) {
    const std::uint64_t packed = PackVoxel(block);
    if (last_ == nullptr || packed != last_packed_) {
      last_ = &blocks_[packed];
      last_packed_ = packed;
    }
    return *last_;
  }
  const T* Find(const VoxelKey& block) const {
    const auto found = blocks_.find(PackVoxel(block));
    return found == blocks_.end() ? nullptr : &found->second;
  }
  const std::unordered_map<std::uint64_t, T>& Blocks() const { return blocks_; }

 private:
  std::unordered_map<std::uint64_t, T> blocks_;
  std::uint64_t last_packed_ = 0;
  T* last_ = nullptr;  // into blocks_, whose nodes never move
};

}  // namespace nightmap
