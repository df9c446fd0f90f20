// SPDX-License-Identifier: Apache-2.0
#include "stages/point_cloud/voxel_filter.h"

#include <algorithm>

#include "pipeline/geometry/voxel_key.h"

namespace nightmap {

void VoxelSum::Add(const VoxelSum& other) {
  weighted_position += other.weighted_position;
  weight += other.weight;
  direction += other.direction;
  color += other.color;
  num_points += other.num_points;
}

void AddPoint(const VoxelSum& point, double voxel_size_m, VoxelSums& sums) {
  sums[PackVoxel(VoxelOf(point.Position(), voxel_size_m))].Add(point);
}

void MergeSums(const VoxelSums& from, VoxelSums& into) {
  for (const auto& [key, sum] : from) into[key].Add(sum);
}

std::vector<VoxelSum> SortedVoxels(const VoxelSums& sums, int min_points) {
  std::vector<std::uint64_t> keys;
  for (const auto& [key, sum] : sums) {
    if (sum.num_points >= static_cast<std::uint32_t>(min_points)) keys.push_back(key);
  }
  std::sort(keys.begin(), keys.end());
  std::vector<VoxelSum> voxels;
  voxels.reserve(keys.size());
  for (const std::uint64_t key : keys) voxels.push_back(sums.at(key));
  return voxels;
}

}  // namespace nightmap
