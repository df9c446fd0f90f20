// SPDX-License-Identifier: Apache-2.0
// voxel_labels: gives the occupied voxels of an octree the classes that keyframes saw there
// (publication CN108596974A: a semantic octree).
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/dense/back_project.h"
#include "pipeline/dense/rgbd_keyframes.h"
#include "pipeline/dense/voxel_labels_io.h"
#include "pipeline/io/frame_labels.h"
#include "pipeline/io/labels_io.h"
#include "stages/labels/voxel_labels/occupied_voxels.h"
#include "stages/labels/voxel_labels/spread_votes.h"

namespace nightmap {

struct VoxelLabelsOptions {
  OPTION(int, keyframe_stride, 1, {1, 1000}, "uses every Nth keyframe");
  OPTION(double, max_range_m, 4.0, {0.1, 100.0},
         "pixels beyond this range do not vote for a label");
  OPTIONS_OF(DepthFilterOptions, depth_filter);
  OPTIONS_OF(SpreadOptions, spread);

  // Every third pixel of every third row: no voxel of 5 cm within 4 m falls between the rays of a
  // usual camera. Pixels on edges and at a slant vote, too: one that flies free is in no occupied
  // voxel.
  VoxelLabelsOptions();
  REGISTER_OPTIONS();
};

struct VoxelLabelsResult {
  VoxelLabels voxels;                // those of `own` for which anything speaks
  std::vector<std::string> skipped;  // one reason for each keyframe left out
  std::size_t num_points = 0;        // depth pixels that voted
};

// Labels of a keyframe's pixels. Called from several threads; throws DataError. The one of
// LoaderOf keeps its arguments by reference.
using LabelLoader = std::function<Segmentation(const Keyframe&)>;

LabelLoader LoaderOf(const FrameLabels& labels, const std::vector<RgbdCamera>& cameras);

// Every depth pixel votes for its label in the voxel that it falls into, with the confidence of the
// label as weight. A keyframe's votes for a voxel are divided by its pixels there, so each keyframe
// counts once, near or far. Pixels in voxels that are not occupied, or beyond max_range_m, do not
// vote. The votes then spread over what looks like one thing (SpreadVotes). Keyframes are added in
// order: same result at any number of threads. Before the votes spread, voxels of parts of a tree
// have the votes that they have in the whole tree, provided that `source` lacks only keyframes that
// do not see the part.
VoxelLabelsResult RunVoxelLabels(const VoxelLabelsOptions& options,
                                 const KeyframeSource& source,
                                 const LabelLoader& labels,
                                 const std::vector<std::string>& classes,
                                 const OccupiedVoxels& occupied,
                                 Progress& progress,
                                 int num_threads);

// Counts for the report.
nlohmann::json Summarize(const KeyframeSource& source,
                         const OccupiedVoxels& occupied,
                         const VoxelLabelsResult& result);

}  // namespace nightmap
