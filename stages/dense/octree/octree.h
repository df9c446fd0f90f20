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
#include "stages/dense/octree/block_colors.h"

namespace nightmap {

struct OctreeOptions {
  OPTION(std::string, builder, "batched", {"batched", "octomap"},
         "batched: nightmap's own; octomap: OctoMap's insertPointCloud, a slow reference for "
         "tests");
  OPTION(int, keyframe_stride, 1, {1, 1000}, "uses every Nth keyframe");
  OPTION(double, resolution_m, 0.05, {0.005, 1.0}, "edge of the smallest voxel");
  OPTION(double, max_range_m, 4.0, {0.1, 100.0},
         "rays are cut at this range; nothing beyond is marked occupied");
  OPTIONS_OF(DepthFilterOptions, depth_filter);
  OPTION(bool, discretize, true, "casts one ray for all pixels of a frame that end in one voxel");
  OPTION(bool, require_cloud_support, true,
         "ignores depth without a point of the cloud in its voxel or a neighbour");
  OPTION(double, carve_margin_sigmas, 1.0, {0.0, 10.0},
         "space within this many sigma of depth noise before a hit is not declared free");
  OPTION(double, probability_hit, 0.7, {0.501, 0.999},
         "probability that a voxel is occupied, given a hit");
  OPTION(double, probability_miss, 0.4, {0.001, 0.499},
         "probability that a voxel is occupied, given a pass");
  OPTION(double, probability_min, 0.12, {0.0001, 0.499}, "lower clamp of the probability");
  OPTION(double, probability_max, 0.97, {0.501, 0.9999}, "upper clamp of the probability");
  OPTION(double, occupancy_threshold, 0.5, {0.01, 0.99},
         "probability from which on a voxel is occupied; the octree holds log-odds less those of "
         "it");
  OPTION(int, min_keyframes, 1, {1, BlockColors::kMaxKeyframes},
         "a voxel that would be occupied, but that fewer keyframes hit, is unknown");
  REGISTER_OPTIONS();
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
