// SPDX-License-Identifier: Apache-2.0
// A tile of the building: a square of the map seen from above, and the keyframes that may see it.
// All that a stage needs to make its part of the map, so that what does not touch a tile does not
// make its artifacts stale. As JSON, one keyframe a line.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/geometry/rectangle.h"
#include "pipeline/io/frames_io.h"

namespace nightmap {

// A frame with depth and its place in the finished trajectory.
struct Keyframe {
  int keyframe_idx = 0;  // in keyframes.tum
  FrameRecord frame;
  Rigid3 map_from_camera;
};

// Which part of the map is made of a list of keyframes. By default all of it.
struct MapRegion {
  Rectangle inside;      // the regions of a site share no point and leave none out
  double overlap_m = 0;  // what lies this far around `inside` is seen by the keyframes too
  double max_range_m = Rectangle::kUnbounded;  // depth to which that holds
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
