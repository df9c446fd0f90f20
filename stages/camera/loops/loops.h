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
  VerifyOptions verify = {.min_spread = 0.05, .max_sigma_m = 0.03, .pose = {.min_inliers = 30}};
  int stride = 1;
  int num_candidates = 4;
  int min_gap = 20;
  int min_quick_inliers = 10;

  void Register(OptionList& list);
};

// Takes every stride-th described frame and finds its loop candidates among the frames at least
// min_gap before it: the best num_candidates of the inverted file, each verified. Returns accepted
// and rejected pairs, sorted by (b, a). Deterministic at any number of threads: each pair draws
// from its own random stream. Throws DataError when the vocabulary was not made from these frames'
// features.
std::vector<FramePair> RunLoops(const LoopsOptions& options,
                                const FramesWithFeatures& input,
                                const Vocabulary& vocabulary,
                                Progress& progress,
                                int num_threads);

}  // namespace nightmap
