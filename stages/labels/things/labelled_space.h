// SPDX-License-Identifier: Apache-2.0
// All that is known of each voxel of the map: the octree, and the classes of its occupied voxels.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/dense/octree_leaves.h"
#include "pipeline/dense/voxel_labels_io.h"

namespace nightmap {

enum class VoxelState : std::uint8_t { kUnknown, kFree, kOccupied };

class LabelledSpace {
 public:
  LabelledSpace(const LeafSource& leaves, const VoxelLabels& voxels);

  double Resolution_m() const { return resolution_m_; }
  // Voxels outside of what an octree reaches are unknown.
  VoxelState At(const VoxelKey& key) const;
  // The class that most speaks for; nothing when the voxel has no votes.
  std::optional<std::uint8_t> LabelAt(const VoxelKey& key) const;

  // Whether nothing is occupied between two points of the map, up to `margin_m` before the second.
  bool IsClear(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double margin_m) const;

 private:
  struct Leaf {
    std::uint64_t code = 0;  // of its first voxel
    std::uint8_t height = 0;
    VoxelState state = VoxelState::kUnknown;

    bool Contains(std::uint64_t other) const { return (other ^ code) >> 3 * height == 0; }
  };

  // The leaf that holds the voxel, or null.
  const Leaf* Find(const VoxelKey& key) const;

  double resolution_m_;
  std::vector<Leaf> leaves_;                   // ascending
  std::vector<std::uint64_t> labelled_codes_;  // ascending
  std::vector<std::uint8_t> labels_;
};

}  // namespace nightmap
