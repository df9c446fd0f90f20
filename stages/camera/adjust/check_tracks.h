// SPDX-License-Identifier: Apache-2.0
// Refuses artifacts of different runs before frames are adjusted by them.
#pragma once

#include "stages/camera/adjust/adjust.h"

namespace nightmap {

// Frames, features and graph must have the same frames; tracks and loops must name features that
// exist; the graph must judge these loops. Throws InputError naming the port, and frame or loop.
void CheckInput(const AdjustInput& input);

// Throws InputError of the port `odometry` when a track has a feature that its frame has not.
void CheckTracks(std::size_t shard_idx, const OdometryShard& shard, const SiteFeatures& features);

}  // namespace nightmap
