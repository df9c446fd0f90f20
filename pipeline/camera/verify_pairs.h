// SPDX-License-Identifier: Apache-2.0
// Verifies many candidate pairs of frames in parallel.
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "pipeline/base/progress.h"
#include "pipeline/camera/verify_pair.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/io/matches_io.h"
#include "pipeline/io/site_features.h"

namespace nightmap {

// The frames that pairs consist of, with their features.
struct FramesWithFeatures {
  std::vector<FrameRecord> frames;  // contiguous frame_idx, starting at frames.front().frame_idx
  std::vector<RgbdCamera> cameras;
  SiteFeatures features;  // of these frames, in their order
};

// Reads the lists of one or more shards, their cameras and the features of the same shards, in the
// same order. Throws DataError naming the file.
FramesWithFeatures ReadFramesWithFeatures(const std::vector<std::filesystem::path>& frames,
                                          const std::filesystem::path& cameras,
                                          const std::vector<std::filesystem::path>& features);

// A candidate, not yet verified.
FramePair MakePair(int frame_a, int frame_b);

// Sorts ascending by (b, a).
void SortPairs(std::vector<FramePair>* pairs);

// A cheap check that rejects most wrong pairs before all of their features are compared.
struct QuickCheck {
  VerifyOptions verify;
  std::function<std::vector<FeatureMatch>(const FrameFeatures& a, const FrameFeatures& b)> match;
};

// Runs VerifyPair on each pair that `quick` accepts (null: on all), with descriptors of the kind of
// the features. Reads each shard about once when the pairs are sorted and few lie far apart. The
// result is the same at any number of threads and in any order.
void VerifyPairs(VerifyOptions options,
                 const QuickCheck* quick,
                 const FramesWithFeatures& input,
                 int num_threads,
                 Progress& progress,
                 std::vector<FramePair>* pairs);

// num_pairs, num_accepted and mean_inliers, for report.json.
nlohmann::json PairsReport(const std::vector<FramePair>& pairs);

}  // namespace nightmap
