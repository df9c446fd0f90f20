// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/features_of_frames.h"

#include "pipeline/base/error.h"

namespace nightmap {

void CheckFeaturesOfFrames(const std::vector<FrameRecord>& frames, const FeaturesShard& features) {
  bool fits = !frames.empty() && frames.size() == features.frames.size();
  for (std::size_t i = 0; fits && i < frames.size(); ++i) {
    fits = frames[i].frame_idx == features.frames[i].frame_idx &&
           frames[i].frame_idx == frames.front().frame_idx + static_cast<int>(i);
  }
  if (!fits) {
    throw DataError(
        "the features are not of the listed frames; delete the features folder of this "
        "site and run make");
  }
}

}  // namespace nightmap
