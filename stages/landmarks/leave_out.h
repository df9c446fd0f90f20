// SPDX-License-Identifier: Apache-2.0
// Features under the masks of the map, which make no landmarks.
#pragma once

#include <vector>

#include "pipeline/io/features_io.h"
#include "pipeline/io/frame_reader.h"

namespace nightmap {

// Takes the features that a frame's mask holds out of each described frame. `frames` are those of
// `features`, in the same order; throws InputError when they are others. Frames that were tracked
// keep theirs, whose reference_features are wrong then: no landmark is made of them. Throws as
// FrameReader::Mask.
void LeaveOut(const std::vector<FrameRecord>& frames,
              const std::vector<RgbdCamera>& cameras,
              const FrameReader& masks,
              FeaturesShard* features);

}  // namespace nightmap
