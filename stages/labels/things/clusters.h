// SPDX-License-Identifier: Apache-2.0
// Groups of voxels of one class that touch each other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/dense/voxel_labels_io.h"

namespace nightmap {

struct Cluster {
  std::uint8_t label = 0;
  std::vector<std::size_t> voxels;  // ascending indices in VoxelLabels
  double mean_share = 0;            // of the class in the votes of these voxels
};

// Takes the voxels of another cluster of the same class.
void AddPart(const Cluster& part, Cluster* whole);

struct ClusterOptions {
  std::vector<std::uint8_t> labels;  // the classes to group, ascending
  double min_share = 0;              // of a voxel's class in its votes; others do not count
  double tolerance_voxels = 0;       // distance of centres at which voxels touch
  int min_voxels = 0;                // of a group
};

// In order of class, then of first voxel.
std::vector<Cluster> FindClusters(const ClusterOptions& options,
                                  const VoxelLabels& voxels,
                                  int num_threads);

}  // namespace nightmap
