// SPDX-License-Identifier: Apache-2.0
// Checks that a list of frames and a list of features belong together.
#pragma once

#include <vector>

#include "pipeline/io/features_io.h"
#include "pipeline/io/frames_io.h"

namespace nightmap {

// Throws DataError unless there are frames, their indices are contiguous, and each has its features
// at the same position.
void CheckFeaturesOfFrames(const std::vector<FrameRecord>& frames, const FeaturesShard& features);

}  // namespace nightmap
