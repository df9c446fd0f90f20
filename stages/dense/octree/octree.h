// SPDX-License-Identifier: Apache-2.0
// octree: divides space into occupied, free and unknown from the depth of all keyframes.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/dense/back_project.h"
#include "pipeline/dense/octree_io.h"
#include "pipeline/dense/ply_io.h"
#include "pipeline/dense/rgbd_keyframes.h"
#include "pipeline/geometry/voxel_key.h"

namespace nightmap {

struct OctreeOptions {
  std::string builder = "batched";
  int keyframe_stride = 1;
  double resolution_m = 0.05;
  double max_range_m = 4.0;
  DepthFilterOptions depth_filter;
  bool discretize = true;
  bool require_cloud_support = true;
  double carve_margin_sigmas = 1.0;
  double probability_hit = 0.7;
  double probability_miss = 0.4;
  double probability_min = 0.12;
  double probability_max = 0.97;
  double occupancy_threshold = 0.5;
  int min_keyframes = 1;

  void Register(OptionList& list);
};

struct OctreeResult {
  OccupancyTree tree;
  std::vector<std::string> skipped;  // one reason for each keyframe left out
  std::size_t num_rays = 0;
  std::size_t num_unsupported = 0;  // depth pixels away from any point of the cloud
  std::size_t num_occupied = 0;     // voxels of the smallest size
  std::size_t num_free = 0;         // voxels of the smallest size
};

// Inserts the keyframes in order. Each changes the log-odds of a voxel at most once: by
// probability_hit where one of its rays ends, else by probability_miss where one passes, else not
// at all. Values are clamped after each keyframe (OctoMap's update rule, Hornung et al. 2013). The
// leaves hold log-odds less those of occupancy_threshold, so that occupied is what reaches 0
// whatever the threshold. A voxel that does so by hits of fewer than min_keyframes keyframes has no
// leaf. A point counts only when `cloud` has a point in its voxel or one of the 26 around (null:
// not checked). Voxels are laid out as OctoMap's; leaves come depth first.
//
// With a `region`, in voxels of resolution_m, the result is the part of the whole tree in that
// region; it may be empty. Disjoint regions that together cover everything join to the whole tree
// by MergeOctrees, byte for byte, provided that `source` and `cloud` are the same or lack only data
// beyond max_range_m of the region. Same result at any number of threads. Throws UsageError when
// the clamps leave the threshold out, DataError when nothing became occupied anywhere.
OctreeResult RunOctree(const OctreeOptions& options,
                       const KeyframeSource& source,
                       const std::vector<CloudPoint>* cloud,
                       const std::optional<VoxelBox>& region,
                       Progress& progress,
                       int num_threads);

}  // namespace nightmap
