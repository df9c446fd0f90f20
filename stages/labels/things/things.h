// SPDX-License-Identifier: Apache-2.0
// things: finds the things that stand in the map, such as chairs and sofas, in its labelled voxels.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/dense/octree_leaves.h"
#include "pipeline/dense/tiles_io.h"
#include "pipeline/dense/voxel_labels_io.h"
#include "pipeline/io/things_io.h"

namespace nightmap {

struct ThingsOptions {
  OPTION(std::vector<std::string>, classes, std::vector<std::string>(),
         "classes of the things to list; empty: all but leave_out");
  OPTION(std::vector<std::string>, leave_out,
         std::vector<std::string>({"none", "background", "wall", "floor", "ceiling", "door",
                                   "window", "lamp", "poster", "object", "person", "bird",
                                   "cat", "cow", "dog", "horse", "sheep"}),
         "classes that are no things; a model may lack some");
  OPTION(double, min_share, 0.5, {0, 1},
         "a voxel counts when so large a share of its votes is for its class");
  OPTION(double, tolerance_voxels, 1.8, {1, 20},
         "distance of centres at which voxels touch; 1.8: the 26 around");
  OPTION(int, min_voxels, 40, {1, 1'000'000}, "leaves out smaller things");
  OPTION(double, max_hidden_m, 0.6, {0, 3},
         "a side may move so far into space that nobody saw, up to a wall");
  OPTION(double, max_range_m, 5, {0.1, 100}, "a keyframe sees things so far");
  REGISTER_OPTIONS();
};

struct ThingsInputs {
  VoxelLabels voxels;
  LeafSource leaves;                // of the octree whose occupied voxels are labelled
  std::vector<Keyframe> keyframes;  // each once, in order of keyframe_idx: UniteKeyframes
  std::vector<RgbdCamera> cameras;
};

// Groups voxels of one class that touch (at most tolerance_voxels apart) to things, joins what was
// seen of one in parts (JoinParts), and describes each by an upright box (FitBox), which is
// completed where nobody saw its end (CompleteBox). The front is the side from which the keyframes
// see it. Things are in order of their class in the model, those of a class in order of their first
// voxel by Morton code, and are numbered so from 1. Metres are rounded to millimetres. Same result
// at any number of threads. Throws UsageError when the model has none of `classes`, InputError when
// voxels and octree have different resolutions, DataError when a keyframe has no camera.
std::vector<Thing> RunThings(const ThingsOptions& options,
                             const ThingsInputs& inputs,
                             Progress& progress,
                             int num_threads);

// The keyframes of all tiles, each once, in order of keyframe_idx.
std::vector<Keyframe> UniteKeyframes(const std::vector<Tile>& tiles);

// Figures for report.json.
nlohmann::json DescribeThings(const std::vector<Thing>& things);

}  // namespace nightmap
