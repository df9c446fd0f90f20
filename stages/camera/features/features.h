// SPDX-License-Identifier: Apache-2.0
// features: keypoints and depth of every frame of a shard, and descriptors of the frames that show
// something new.
#pragma once

#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/camera/extract_features.h"
#include "pipeline/labels/labelled_frames.h"
#include "stages/camera/features/track_features.h"

namespace nightmap {

struct FeaturesOptions {
  OPTIONS_OF(ExtractionOptions, extraction);
  OPTIONS_OF(TrackingOptions, tracking);
  OPTION(int, segment_frames, 50, {1, 1e6},
         "length of a run of frames that is processed in order; its first frame is described");
  OPTION(double, max_failed_ratio, 0.2, {0, 1}, "fails when a larger share of the frames failed");
  REGISTER_OPTIONS();
};

struct FeaturesInput {
  std::vector<FrameRecord> frames;
  std::vector<RgbdCamera> cameras;
  RgbdLoader load;
  // Labels what moves in the frames that are described, and in those that are due; it is left out
  // of their pixels, and tracks that run into it end. Frames that it cannot label are not
  // described. May be null: nothing moves.
  LabelledFrames* labelled = nullptr;
};

// Motion is found with depth as far as it is measured, by its sigma; max_depth_m bounds the map.
std::vector<RgbdCamera> WithoutMaxDepth(std::vector<RgbdCamera> cameras);

struct FeaturesResult {
  FeaturesShard shard;  // one entry per frame, in order; a failed frame has no features
  std::vector<std::string> skipped;  // reasons, in frame order
};

// The first frame of each segment and the last frame of the shard are described. The others are
// tracked from the last described frame as long as enough of its features are found. A segment
// begins at a frame that may be described. Deterministic at any number of threads: segments are
// independent.
FeaturesResult RunFeatures(const FeaturesOptions& options,
                           const FeaturesInput& input,
                           Progress& progress,
                           int num_threads);

}  // namespace nightmap
