// SPDX-License-Identifier: Apache-2.0
// matches: verified pairs of frames. Two jobs share one program and one config: the pairs of a
// shard (each frame with a few frames before it) and the loops (each frame with frames that look
// alike).
#pragma once

#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/geometry/absolute_pose.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/io/matches_io.h"
#include "pipeline/vision/vocabulary_io.h"

namespace nightmap {

struct MatchesOptions {
  double max_ratio = 0.85;
  std::vector<int> pair_offsets = {1, 2, 4, 8};
  double max_error_px = 3.0;
  double max_depth_error = 0.1;
  int min_inliers = 15;
  double min_spread = 0.02;
  int loop_stride = 2;
  int loop_num_candidates = 4;
  int loop_min_gap = 20;
  int loop_min_inliers = 30;
  double loop_min_spread = 0.05;
  int max_ransac_iterations = 2000;
  int seed = 0;

  void Register(OptionList& list);
};

// What the matching needs to know of the frames, by frame index.
struct MatchesInput {
  std::vector<FrameRecord> frames;  // contiguous frame_idx, starting at frames.front().frame_idx
  std::vector<RgbdCamera> cameras;
  FeaturesShard features;  // of the same frames, in the same order
};

// Pairs (first_frame_idx <= b, b - offset) for every offset of the config, sorted by (b, a). Frames
// before first_frame_idx are only partners. Deterministic at any number of threads: each pair draws
// from its own random stream.
std::vector<FramePair> MatchNeighbours(const MatchesOptions& options,
                                       const MatchesInput& input,
                                       int first_frame_idx,
                                       int num_threads,
                                       Progress& progress);

// Loop candidates of every loop_stride-th frame among the frames at least loop_min_gap before it,
// best loop_num_candidates of the inverted file, each verified. Accepted and rejected are returned.
std::vector<FramePair> MatchLoops(const MatchesOptions& options,
                                  const MatchesInput& input,
                                  const Vocabulary& vocabulary,
                                  int num_threads,
                                  Progress& progress);

}  // namespace nightmap
