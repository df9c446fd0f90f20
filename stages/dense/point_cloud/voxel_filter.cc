// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/point_cloud/voxel_filter.h"

#include <algorithm>

#include "pipeline/geometry/voxel_key.h"

namespace nightmap {

void VoxelSum::Add(const VoxelSum& other) {
  weighted_position += other.weighted_position;
  weight += other.weight;
  direction += other.direction;
  color += other.color;
  num_points += other.num_points;
  folds |= other.folds;
}

void AddPoint(const VoxelSum& point, double voxel_size_m, VoxelSums& sums) {
  sums[PackVoxel(VoxelOf(point.Position(), voxel_size_m))].Add(point);
}

void MergeSums(const VoxelSums& from, VoxelSums& into) {
  for (const auto& [key, sum] : from) into[key].Add(sum);
}

SortedVoxels SortVoxels(const VoxelSums& sums, int min_points) {
  SortedVoxels voxels;
  for (const auto& [key, sum] : sums) {
    if (sum.num_points >= static_cast<std::uint32_t>(min_points)) voxels.keys.push_back(key);
  }
  std::sort(voxels.keys.begin(), voxels.keys.end());
  voxels.sums.reserve(voxels.keys.size());
  for (const std::uint64_t key : voxels.keys) voxels.sums.push_back(sums.at(key));
  return voxels;
}

std::vector<Eigen::Vector3d> Positions(const std::vector<VoxelSum>& sums) {
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(sums.size());
  for (const VoxelSum& sum : sums) positions.push_back(sum.Position());
  return positions;
}

}  // namespace nightmap
