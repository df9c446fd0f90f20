// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/things/labelled_space.h"

#include <algorithm>
#include <cmath>

namespace nightmap {
namespace {

constexpr int kReach = 1 << (kOctreeDepth - 1);  // voxels along each axis, from the origin

bool IsInReach(const VoxelKey& key) {
  return (key.array() >= -kReach).all() && (key.array() < kReach).all();
}

}  // namespace

LabelledSpace::LabelledSpace(const LeafSource& leaves, const VoxelLabels& voxels)
    : resolution_m_(leaves.resolution_m) {
  leaves.visit([&](const PlacedLeaf& leaf) {
    const VoxelState state = leaf.Occupied() ? VoxelState::kOccupied : VoxelState::kFree;
    leaves_.push_back({leaf.code, leaf.height, state});
  });
  labelled_codes_.reserve(voxels.Size());
  labels_.reserve(voxels.Size());
  for (std::size_t i = 0; i < voxels.Size(); ++i) {
    labelled_codes_.push_back(MortonCode(voxels.keys[i]));
    labels_.push_back(LabelOf(voxels, i).label);
  }
}

const LabelledSpace::Leaf* LabelledSpace::Find(const VoxelKey& key) const {
  if (!IsInReach(key)) return nullptr;
  const std::uint64_t code = MortonCode(key);
  const auto behind = std::ranges::upper_bound(leaves_, code, {}, &Leaf::code);
  if (behind == leaves_.begin()) return nullptr;
  const Leaf& leaf = *std::prev(behind);
  return leaf.Contains(code) ? &leaf : nullptr;
}

VoxelState LabelledSpace::At(const VoxelKey& key) const {
  const Leaf* leaf = Find(key);
  return leaf ? leaf->state : VoxelState::kUnknown;
}

std::optional<std::uint8_t> LabelledSpace::LabelAt(const VoxelKey& key) const {
  if (!IsInReach(key)) return {};
  const std::uint64_t code = MortonCode(key);
  const auto found = std::ranges::lower_bound(labelled_codes_, code);
  if (found == labelled_codes_.end() || *found != code) return {};
  return labels_[static_cast<std::size_t>(found - labelled_codes_.begin())];
}

// In steps of half a voxel: a ray that misses the corner of a voxel by them touches it only.
bool LabelledSpace::IsClear(const Eigen::Vector3d& from,
                            const Eigen::Vector3d& to,
                            double margin_m) const {
  const Eigen::Vector3d ray = to - from;
  const double length_m = ray.norm();
  const double step_m = resolution_m_ / 2;
  const Leaf* leaf = nullptr;
  for (double along_m = 0; along_m < length_m - margin_m; along_m += step_m) {
    const VoxelKey key = VoxelOf(from + along_m / length_m * ray, resolution_m_);
    const bool is_same = leaf && IsInReach(key) && leaf->Contains(MortonCode(key));
    if (!is_same) leaf = Find(key);
    if (leaf && leaf->state == VoxelState::kOccupied) return false;
  }
  return true;
}

}  // namespace nightmap
