// SPDX-License-Identifier: Apache-2.0
// loops: finds verified pairs of frames that look alike, however far apart in time.
#pragma once

#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/camera/verify_pairs.h"
#include "pipeline/camera/vocabulary_io.h"

namespace nightmap {

struct LoopsOptions {
  VerifyOptions verify{.pose = {.min_inliers = 30}, .min_spread = 0.05, .max_sigma_m = 0.03};
  OPTIONS_AT(verify);
  OPTION(int, stride, 1, {1, 1000}, "every Nth described frame looks for loops");
  OPTION(int, min_gap, 20, {1, 100000}, "smallest number of frames between the ends of a loop");
  REGISTER_OPTIONS();
};

// Takes every stride-th described frame and finds its loop candidates among the frames at least
// min_gap before it: the best four of the inverted file, each verified. Returns accepted
// and rejected pairs, sorted by (b, a). Deterministic at any number of threads: each pair draws
// from its own random stream. Holds the words of all frames, and the features of a few shards.
// Throws DataError when the vocabulary was not made from these frames' features.
std::vector<FramePair> RunLoops(const LoopsOptions& options,
                                const FramesWithFeatures& input,
                                const Vocabulary& vocabulary,
                                Progress& progress,
                                int num_threads);

}  // namespace nightmap
