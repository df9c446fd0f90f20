// SPDX-License-Identifier: Apache-2.0
// octree: which space is occupied, free or unknown, from the depth of all keyframes.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/io/octree_io.h"
#include "pipeline/io/ply_io.h"
#include "pipeline/vision/back_project.h"
#include "pipeline/vision/rgbd_keyframes.h"

namespace nightmap {

struct OctreeOptions {
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
  double max_failed_ratio = 0.05;

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

// Inserts the keyframes' rays in order: hits where they end, misses where they pass, nothing where
// depth is missing (OctoMap's update rule, Hornung et al. 2013). A point counts only when `cloud`
// (null: not asked) has a point in its voxel or one of the 26 around. Voxels are as OctoMap lays
// them out. Same result at any number of threads. Throws DataError when nothing became occupied.
OctreeResult RunOctree(const OctreeOptions& options,
                       const KeyframeSource& source,
                       const std::vector<CloudPoint>* cloud,
                       Progress& progress,
                       int num_threads);

}  // namespace nightmap
