// SPDX-License-Identifier: Apache-2.0
// Refuses artifacts of different runs before frames are adjusted by them.
#pragma once

#include "stages/camera/adjust/adjust.h"

namespace nightmap {

// Frames, features and graph must have the same frames. Throws InputError naming the port.
void CheckFrames(const AdjustInput& input);

// Loops must name features that exist, and the graph must judge these loops. Throws InputError
// naming the port and the loop.
void CheckLoops(const AdjustInput& input, const std::vector<FramePair>& loops);

// Throws InputError of the port `odometry` when a track has a feature that its frame has not.
void CheckTracks(std::size_t shard_idx, const OdometryShard& shard, const SiteFeatures& features);

}  // namespace nightmap
