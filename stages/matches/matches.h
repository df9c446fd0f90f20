// SPDX-License-Identifier: Apache-2.0
// matches: verified pairs of frames. Two jobs share one program and one config: the pairs of a
// shard (each described frame with a few described ones before it, each tracked frame with the one
// it was tracked from) and the loops (each described frame with those that look alike).
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
  std::vector<int> pair_offsets = {1, 2, 4};
  int wide_search = 16;
  double max_error_px = 3.0;
  double max_depth_error = 0.1;
  int min_inliers = 15;
  double min_spread = 0.02;
  int loop_stride = 1;
  int loop_num_candidates = 4;
  int loop_min_gap = 20;
  int loop_min_inliers = 30;
  int loop_min_quick_inliers = 10;
  double loop_min_spread = 0.05;
  double loop_max_sigma_m = 0.03;
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

// For every described frame b of first_frame_idx or later and every offset of the config the pair
// with the described frame that many before it; for every tracked frame b the pair with its
// reference. A described frame without any accepted pair is also matched to all of the wide_search
// described frames before it. Sorted by (b, a). Frames before first_frame_idx are only partners.
// Deterministic at any number of threads: each pair draws from its own random stream.
std::vector<FramePair> MatchNeighbours(const MatchesOptions& options,
                                       const MatchesInput& input,
                                       int first_frame_idx,
                                       int num_threads,
                                       Progress& progress);

// Loop candidates of every loop_stride-th described frame among those at least loop_min_gap before
// it, best loop_num_candidates of the inverted file, each verified. Accepted and rejected are
// returned.
std::vector<FramePair> MatchLoops(const MatchesOptions& options,
                                  const MatchesInput& input,
                                  const Vocabulary& vocabulary,
                                  int num_threads,
                                  Progress& progress);

}  // namespace nightmap
