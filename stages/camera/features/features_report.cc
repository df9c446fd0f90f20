// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/features/features_report.h"

#include <algorithm>

namespace nightmap {

nlohmann::json Summarize(const FeaturesShard& shard) {
  int num_features = 0;
  int num_with_depth = 0;
  int num_empty_frames = 0;
  int num_described = 0;
  for (const FrameFeatures& frame : shard.frames) {
    num_features += frame.NumFeatures();
    num_with_depth += static_cast<int>(
        std::ranges::count_if(frame.depths_m, [](float depth_m) { return depth_m > 0; }));
    num_empty_frames += frame.NumFeatures() == 0;
    num_described += frame.IsDescribed();
  }
  return {{"num_frames", shard.frames.size()},
          {"num_described_frames", num_described},
          {"num_features", num_features},
          {"num_features_with_depth", num_with_depth},
          {"num_frames_without_features", num_empty_frames}};
}

}  // namespace nightmap
