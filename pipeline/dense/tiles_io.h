// SPDX-License-Identifier: Apache-2.0
// A tile of the building: a square of the map seen from above, and the keyframes that may see it.
// It holds all data that a stage needs for its part of the map, so that changes elsewhere do not
// make its artifacts stale. As JSON, one keyframe per line.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/geometry/rectangle.h"
#include "pipeline/io/frames_io.h"

namespace nightmap {

// A frame with depth and its place in the finished trajectory.
struct Keyframe {
  int keyframe_idx = 0;  // index in keyframes.tum
  FrameRecord frame;
  Rigid3 map_from_camera;
};

// The part of the map to make from a list of keyframes; by default all of it.
struct MapRegion {
  Rectangle inside;      // regions of a site are disjoint and cover everything
  double overlap_m = 0;  // the keyframes also see everything this far around `inside`
  double max_range_m = Rectangle::kUnbounded;  // depth up to which that holds
};

struct Tile {
  MapRegion region;                 // bounded
  std::vector<Keyframe> keyframes;  // in order of keyframe_idx
};

// Equal tiles give equal bytes; numbers are exact.
std::string TileToJson(const Tile& tile);
// Throws DataError naming the file on another format, a newer version, numbers that are not finite,
// an empty region, or keyframes out of order.
Tile ReadTile(const std::filesystem::path& path);

}  // namespace nightmap
