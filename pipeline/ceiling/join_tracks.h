// SPDX-License-Identifier: Apache-2.0
// Tracks of a whole site from those of its shards.
#pragma once

#include <vector>

#include "pipeline/ceiling/corner_tracks_io.h"

namespace nightmap {

// Each file but the first begins with the last frame of the one before. Tracks of both that are at
// one pixel there, within `max_distance_px`, are one: the nearest pairs first. It keeps the id, and
// the descriptor, that it had first. Throws InputError of the port `tracks` when the files do not
// follow one another. Deterministic.
CornerTracks JoinTracks(std::vector<CornerTracks> shards, double max_distance_px);

}  // namespace nightmap
