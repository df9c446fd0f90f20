// SPDX-License-Identifier: Apache-2.0
// Files that all stages that map a ceiling read and write.
#pragma once

#include "pipeline/ceiling/ceiling_map_io.h"
#include "pipeline/ceiling/corner_tracks_io.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/program/stage_context.h"

namespace nightmap {

// The camera of all frames. Throws InputError of the port `frames` when they are of several cameras
// or recordings: a ceiling is mapped by one robot without a break.
RgbdCamera OneCamera(const std::vector<FrameRecord>& frames,
                     const std::vector<RgbdCamera>& cameras);

struct CeilingTracks {
  RgbdCamera camera;
  CornerTracks tracks;  // of the whole site
};

// Reads the inputs `frames`, `cameras` and `tracks`; the tracks are of all shards, in order.
CeilingTracks ReadCeilingTracks(StageContext& context);

// Writes the outputs `trajectory` (map_from_robot at each frame), `map` and `ply`.
void WriteCeiling(const CeilingMap& map, StageContext& context);

}  // namespace nightmap
