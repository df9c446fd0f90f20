// SPDX-License-Identifier: Apache-2.0
// features: keypoints, descriptors and depth of every frame of a shard.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/vision/extract_features.h"

namespace nightmap {

struct FeaturesOptions {
  ExtractionOptions extraction;
  double max_failed_ratio = 0.2;

  void Register(OptionList& list) {
    extraction.Register(list);
    list.Add("max_failed_ratio",
             &max_failed_ratio,
             Range(0, 1),
             "share of unreadable frames above which the stage fails");
  }
};

// Throws DataError when the frame's pixels cannot be read.
using RgbdLoader = std::function<RgbdImages(const FrameRecord&)>;

struct FeaturesResult {
  FeaturesShard shard;  // one entry a frame, in order; an unreadable frame has no features
  std::vector<std::string> skipped;  // reasons, in frame order
};

// Deterministic at any number of threads: frames are independent.
FeaturesResult RunFeatures(const FeaturesOptions& options,
                           const std::vector<FrameRecord>& frames,
                           const std::vector<RgbdCamera>& cameras,
                           const RgbdLoader& load,
                           int num_threads,
                           Progress& progress);

}  // namespace nightmap
