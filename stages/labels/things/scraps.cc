// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/things/scraps.h"

#include <algorithm>
#include <cstdint>
#include <set>

#include "pipeline/dense/octree_io.h"

namespace nightmap {
namespace {

constexpr int kMaxLayers = 3;  // of a stain; a floor with the noise of depth has two
constexpr double kMinRimShare = 0.5;
constexpr int kMaxLegWidth = 2;
constexpr int kMinLegSlenderness = 4;

// Whether the floor goes on at a place beside a voxel.
bool IsFloor(const LabelledSpace& space,
             const std::array<bool, 256>& is_thing_class,
             const VoxelKey& key) {
  for (int dz = -1; dz <= 1; ++dz) {
    const VoxelKey near = key + VoxelKey(0, 0, dz);
    if (space.At(near) != VoxelState::kOccupied) continue;
    const auto label = space.LabelAt(near);
    if (!label || !is_thing_class[*label]) return true;
  }
  return false;
}

}  // namespace

bool IsStain(const VoxelLabels& voxels,
             const LabelledSpace& space,
             const std::array<bool, 256>& is_thing_class,
             const Cluster& cluster) {
  std::set<std::pair<int, int>> columns;
  int lowest = voxels.keys[cluster.voxels.front()].z();
  int highest = lowest;
  for (const std::size_t i : cluster.voxels) {
    const VoxelKey& key = voxels.keys[i];
    columns.insert({key.x(), key.y()});
    lowest = std::min(lowest, key.z());
    highest = std::max(highest, key.z());
  }
  if (highest - lowest >= kMaxLayers) return false;
  int num_rim = 0, num_floor = 0;
  for (const std::size_t i : cluster.voxels) {
    for (const VoxelKey& step : {VoxelKey(1, 0, 0), {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}}) {
      const VoxelKey beside = voxels.keys[i] + step;
      if (columns.contains({beside.x(), beside.y()})) continue;
      ++num_rim;
      num_floor += IsFloor(space, is_thing_class, beside);
    }
  }
  return num_floor > kMinRimShare * num_rim;
}

bool IsLeg(const VoxelLabels& voxels, const Cluster& cluster) {
  VoxelKey min = voxels.keys[cluster.voxels.front()];
  VoxelKey max = min;
  for (const std::size_t i : cluster.voxels) {
    min = min.cwiseMin(voxels.keys[i]);
    max = max.cwiseMax(voxels.keys[i]);
  }
  const VoxelKey size = max - min + VoxelKey::Ones();
  const int width = std::max(size.x(), size.y());
  return width <= kMaxLegWidth && size.z() >= kMinLegSlenderness * width;
}

}  // namespace nightmap
