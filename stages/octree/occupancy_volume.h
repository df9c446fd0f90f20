// SPDX-License-Identifier: Apache-2.0
// Log-odds fusion of scans, kept in blocks of voxels and handed over as octree leaves.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "pipeline/io/octree_io.h"
#include "stages/octree/scan.h"

namespace nightmap {

// Log-odds of the inverse sensor model (Moravec and Elfes, High resolution maps from wide angle
// sonar, 1985) with clamping, which lets a map follow change and its octree be pruned.
struct SensorModel {
  float hit = 0.85F;
  float miss = -0.4F;
  float min = -2.0F;
  float max = 3.5F;
};

class OccupancyVolume {
 public:
  explicit OccupancyVolume(const SensorModel& model) : model_(model) {}

  // Scans must come in a fixed order: clamping makes the sum depend on it.
  void Integrate(const ScanEvidence& evidence);

  // Known voxels, depth first; a block whose voxels are all free with one value becomes one leaf.
  OccupancyTree Leaves(double resolution_m) const;

 private:
  struct Block {
    std::array<float, kBlockVoxels> log_odds{};
    BlockBits known;
    std::unique_ptr<std::array<ColorSum, kBlockVoxels>> colors;  // of blocks with a hit
  };

  void AppendBlock(const VoxelKey& key, const Block& block, OccupancyTree& tree) const;

  SensorModel model_;
  BlockMap<Block> blocks_;
};

}  // namespace nightmap
