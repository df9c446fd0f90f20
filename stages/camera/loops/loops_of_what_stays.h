// SPDX-License-Identifier: Apache-2.0
// Loops without what may move, even if it stands still: people stand here now and there later.
#pragma once

#include <vector>

#include "pipeline/camera/leave_out.h"
#include "stages/camera/loops/loops.h"

namespace nightmap {

// As RunLoops, without the features that masks hold; `masked_frames` are those of the input, with
// the channel of their masks. Indices of features are those of the input. Throws as
// UnmaskedFeatures too.
std::vector<FramePair> RunLoopsOfWhatStays(const LoopsOptions& options,
                                           FramesWithFeatures input,
                                           Vocabulary vocabulary,
                                           const std::vector<FrameRecord>& masked_frames,
                                           const FrameReader& masks,
                                           Progress& progress,
                                           int num_threads);

}  // namespace nightmap
