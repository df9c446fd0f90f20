// SPDX-License-Identifier: Apache-2.0
// Points that several keyframes see, across all shards.
#pragma once

#include <set>
#include <vector>

#include "stages/camera/adjust/adjust.h"
#include "stages/camera/adjust/track_list.h"

namespace nightmap {

// The tracks of all shards with two observations or more, joined where they share a feature and
// where an accepted loop joins two. Keeps only observations in `keyframes`. Reads one shard at a
// time, and holds what keyframes and ends of loops see. Throws InputError when a track has a
// feature that is none of the input's.
TrackList MergeTracks(const AdjustInput& input,
                      const std::vector<FramePair>& loops,
                      const std::set<int>& keyframes);

// The tracks without their observations in `dropped`.
TrackList WithoutFrames(const TrackList& tracks, const std::set<int>& dropped);

}  // namespace nightmap
