// SPDX-License-Identifier: Apache-2.0
// Fuses points by the voxel that they fall into.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace nightmap {

// Sums over the points of one voxel.
struct VoxelSum {
  Eigen::Vector3d weighted_position = Eigen::Vector3d::Zero();
  double weight = 0;  // sum of 1 / sigma^2
  // Sum of directions to the cameras, or the normal.
  Eigen::Vector3f direction = Eigen::Vector3f::Zero();
  Eigen::Array3f color = Eigen::Array3f::Zero();  // sum of colors 0..255
  std::uint32_t num_points = 0;
  std::uint8_t folds = 0;  // one bit per fold of keyframes that measured it (held_out_rays.h)

  void Add(const VoxelSum& other);
  Eigen::Vector3d Position() const { return weighted_position / weight; }
};

// Sums keyed by PackVoxel. Add the sums of one voxel in one fixed order: floating-point addition is
// not associative.
using VoxelSums = std::unordered_map<std::uint64_t, VoxelSum>;

void AddPoint(const VoxelSum& point, double voxel_size_m, VoxelSums& sums);
void MergeSums(const VoxelSums& from, VoxelSums& into);

// Sums in order of their voxels.
struct SortedVoxels {
  std::vector<std::uint64_t> keys;  // packed
  std::vector<VoxelSum> sums;
};

// Voxels with at least `min_points` points.
SortedVoxels SortVoxels(const VoxelSums& sums, int min_points);

// The voxels whose index satisfies `keep`.
template <typename Predicate>
SortedVoxels Select(const SortedVoxels& voxels, const Predicate& keep) {
  SortedVoxels kept;
  for (std::size_t i = 0; i < voxels.keys.size(); ++i) {
    if (!keep(i)) continue;
    kept.keys.push_back(voxels.keys[i]);
    kept.sums.push_back(voxels.sums[i]);
  }
  return kept;
}

std::vector<Eigen::Vector3d> Positions(const std::vector<VoxelSum>& sums);

}  // namespace nightmap
