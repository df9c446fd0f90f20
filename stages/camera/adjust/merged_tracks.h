// SPDX-License-Identifier: Apache-2.0
// Points that several keyframes see, across all shards.
#pragma once

#include <set>
#include <vector>

#include "pipeline/io/matches_io.h"
#include "pipeline/io/odometry_io.h"

namespace nightmap {

// The shards' tracks with two observations or more, joined where they share a feature and where a
// loop joins two. Keeps only observations in `keyframes`. `is_accepted[i]` belongs to loops[i].
std::vector<Track> MergeTracks(const std::vector<OdometryShard>& shards,
                               const std::vector<FramePair>& loops,
                               const std::vector<bool>& is_accepted,
                               const std::set<int>& keyframes);

// The tracks without their observations in `dropped`.
std::vector<Track> WithoutFrames(std::vector<Track> tracks, const std::set<int>& dropped);

}  // namespace nightmap
