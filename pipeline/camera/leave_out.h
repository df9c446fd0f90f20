// SPDX-License-Identifier: Apache-2.0
// Features under masks of what may move, or of what stays out of the map.
#pragma once

#include <vector>

#include "pipeline/io/features_io.h"
#include "pipeline/io/frame_reader.h"

namespace nightmap {

// Per frame and feature that was left, its index before.
using IndicesBefore = std::vector<std::vector<int>>;

// Takes the features that a frame's mask holds out of each described frame. `frames` are those of
// `features`, in the same order; throws InputError when they are others. Frames that were tracked
// keep theirs, whose reference_features are wrong then. Throws as FrameReader::Mask.
IndicesBefore LeaveOut(const std::vector<FrameRecord>& frames,
                       const std::vector<RgbdCamera>& cameras,
                       const FrameReader& masks,
                       FeaturesShard* features);

}  // namespace nightmap
