// SPDX-License-Identifier: Apache-2.0
// Labels of the occupied voxels of an octree: for each voxel, how much the keyframes that see it
// speak for each class.
//
// HDF5, for N voxels with V votes:
//   resolution_m  double[1]     edge of a voxel
//   key           int32[N x 3]  cube [key, key + 1) * resolution_m in the map frame, in Morton
//   order num_views     int32[N]      keyframes that labelled the voxel; 0: only voxels around it
//   were vote_offset   int64[N+1] first vote of each voxel vote_label    uint8[V]      class;
//   ascending in a voxel vote_weight float[V]      sum over keyframes of their mean confidence that
//   it is this class text classes names of the classes by label, one per line
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/geometry/voxel_key.h"

namespace nightmap {

struct VoxelLabels {
  double resolution_m = 0;
  std::vector<std::string> classes;  // names by label; none where there are no voxels
  std::vector<VoxelKey> keys;        // in order of MortonCode; each once
  std::vector<std::int32_t> num_views;
  std::vector<std::size_t> vote_offsets = {0};  // one more than keys
  std::vector<std::uint8_t> vote_labels;
  std::vector<float> vote_weights;  // positive

  std::size_t Size() const { return keys.size(); }
};

// The class that most speaks for, and its share of all votes. A voxel always has a vote.
struct VoxelLabel {
  std::uint8_t label = 0;
  double share = 0;  // 0 .. 1
};
VoxelLabel LabelOf(const VoxelLabels& voxels, std::size_t i);

void WriteVoxelLabels(const std::filesystem::path& path,
                      const VoxelLabels& voxels,
                      const std::string& config);
// Throws DataError naming file and field on sizes that do not fit, labels of no class, weights that
// are not positive, or keys out of order or of the range of octrees.
VoxelLabels ReadVoxelLabels(const std::filesystem::path& path);

}  // namespace nightmap
