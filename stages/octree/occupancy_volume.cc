// SPDX-License-Identifier: Apache-2.0
#include "stages/octree/occupancy_volume.h"

#include <algorithm>

namespace nightmap {
namespace {

std::array<std::uint8_t, 3> MeanColor(const ColorSum& sum) {
  std::array<std::uint8_t, 3> mean{};
  for (std::size_t channel = 0; channel < 3; ++channel) {
    mean[channel] = static_cast<std::uint8_t>((sum.rgb[channel] + sum.count / 2) / sum.count);
  }
  return mean;
}

bool IsUniform(const std::array<float, kBlockVoxels>& values) {
  return std::all_of(values.begin(), values.end(), [&](float value) { return value == values[0]; });
}

}  // namespace

void OccupancyVolume::Integrate(const ScanEvidence& evidence) {
  for (const auto& [packed, scanned] : evidence.blocks.Blocks()) {
    Block& block = blocks_.At(UnpackVoxel(packed));
    const BlockBits touched = scanned.hit | scanned.passed;
    for (std::size_t i = touched._Find_first(); i < kBlockVoxels; i = touched._Find_next(i)) {
      const float update = scanned.hit.test(i) ? model_.hit : model_.miss;
      block.log_odds[i] = std::clamp(block.log_odds[i] + update, model_.min, model_.max);
    }
    block.known |= touched;
  }
  for (const HitColor& hit : evidence.colors) {
    Block& block = blocks_.At(BlockOf(hit.voxel));
    if (!block.colors) block.colors = std::make_unique<std::array<ColorSum, kBlockVoxels>>();
    ColorSum& sum = (*block.colors)[IndexInBlock(hit.voxel)];
    for (std::size_t channel = 0; channel < 3; ++channel)
      sum.rgb[channel] += hit.color.rgb[channel];
    sum.count += hit.color.count;
  }
}

void OccupancyVolume::AppendBlock(const VoxelKey& key,
                                  const Block& block,
                                  OccupancyTree& tree) const {
  if (block.known.all() && block.log_odds[0] < 0 && IsUniform(block.log_odds)) {
    const double size_m = tree.resolution_m * kBlockEdge;
    tree.leaves.push_back({VoxelCentre(key, size_m), size_m, block.log_odds[0]});
    return;
  }
  static constexpr auto kOrder = MortonOrderInBlock();
  for (const std::size_t i : kOrder) {
    if (!block.known.test(i)) continue;
    OccupancyVoxel leaf{
        VoxelCentre(VoxelInBlock(key, i), tree.resolution_m), tree.resolution_m, block.log_odds[i]};
    if (leaf.Occupied() && block.colors && (*block.colors)[i].count > 0) {
      leaf.rgb = MeanColor((*block.colors)[i]);
    }
    tree.leaves.push_back(leaf);
  }
}

OccupancyTree OccupancyVolume::Leaves(double resolution_m) const {
  std::vector<VoxelKey> keys;
  for (const auto& [packed, block] : blocks_.Blocks()) keys.push_back(UnpackVoxel(packed));
  std::ranges::sort(keys, {}, MortonCode);
  OccupancyTree tree;
  tree.resolution_m = resolution_m;
  for (const VoxelKey& key : keys) AppendBlock(key, *blocks_.Find(key), tree);
  return tree;
}

}  // namespace nightmap
