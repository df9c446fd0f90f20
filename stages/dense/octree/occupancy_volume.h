// SPDX-License-Identifier: Apache-2.0
// Log-odds fusion of keyframes in blocks of voxels, exported as octree leaves.
#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <memory>
#include <span>

#include "pipeline/dense/octree_io.h"
#include "stages/dense/octree/block_colors.h"
#include "stages/dense/octree/sensor_model.h"
#include "stages/dense/octree/trace_rays.h"

namespace nightmap {

class OccupancyVolume {
 public:
  explicit OccupancyVolume(const SensorModel& model);

  // Adds the model's hit or miss to each voxel, keyframe by keyframe, then clamps. A keyframe
  // changes a voxel at most once, and the order of the keyframes matters. A new voxel begins at 0.
  // Threads divide the space, not the keyframes, so none waits for another and the result is the
  // same for any number.
  void Integrate(std::span<const KeyframeEvidence> keyframes, int num_threads);

  // Known voxels, depth first, merged like LeafList, but for those that too few keyframes hit.
  // Occupied ones have the mean of the colors that hit them.
  OccupancyTree Leaves(double resolution_m, int num_threads) const;

 private:
  struct Block {
    alignas(16) std::array<float, kBlockVoxels> log_odds{};
    BlockBits known;
    std::array<bool, kBlockWords> settled{};  // words of voxels that cannot become any freer
    BlockColors colors;
  };
  // A cube of 8 x 8 x 8 blocks, the unit of work of a thread.
  using Region = std::array<std::unique_ptr<Block>, kBlockVoxels>;
  // Increments of four voxels, by their four bits of evidence.
  using Updates = std::array<Eigen::Array4f, 16>;

  static Updates MakeUpdates(float log_odds);
  void Update(const BlockEvidence& evidence, Block& block) const;

  SensorModel model_;
  Updates of_hit_;
  Updates of_miss_;
  std::map<std::uint64_t, Region> regions_;
};

}  // namespace nightmap
