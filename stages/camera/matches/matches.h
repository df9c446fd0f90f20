// SPDX-License-Identifier: Apache-2.0
// matches: verified pairs of frames near each other in time. Each described frame is paired with a
// few described frames before it, each tracked frame with the frame it was tracked from.
#pragma once

#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/camera/verify_pairs.h"

namespace nightmap {

struct MatchesOptions {
  VerifyOptions verify{.pose = {.min_inliers = 15}, .min_spread = 0.02};
  OPTIONS_AT(verify);
  OPTION(std::vector<int>, pair_offsets, std::vector<int>({1, 2, 4}), {1, 100},
         "each described frame is matched to the described frames at these offsets before it");
  OPTION(int, wide_search, 16, {0, 1000},
         "a described frame without a match among these is matched to this many before it");
  REGISTER_OPTIONS();
};

// Pairs each described frame b from first_frame_idx on, for each offset of the config, with the
// described frame that many before it, and each tracked frame b with its reference. A described
// frame without any accepted pair is also matched to all of the wide_search described frames before
// it. Sorted by (b, a). Frames before first_frame_idx serve only as partners. Deterministic at any
// number of threads: each pair draws from its own random stream.
std::vector<FramePair> RunMatches(const MatchesOptions& options,
                                  const FramesWithFeatures& input,
                                  int first_frame_idx,
                                  Progress& progress,
                                  int num_threads);

}  // namespace nightmap
