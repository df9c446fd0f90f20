// SPDX-License-Identifier: Apache-2.0
// Whether two lists that a stage was given belong together.
#pragma once

#include <vector>

#include "pipeline/io/features_io.h"
#include "pipeline/io/frames_io.h"

namespace nightmap {

// Throws DataError unless there are frames, contiguous ones, and each has its features at the same
// place.
void CheckFeaturesOfFrames(const std::vector<FrameRecord>& frames, const FeaturesShard& features);

}  // namespace nightmap
