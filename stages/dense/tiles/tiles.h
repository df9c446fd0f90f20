// SPDX-License-Identifier: Apache-2.0
// tiles: cuts the building into squares, so that each is mapped on its own in bounded memory.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/dense/tiles_io.h"

namespace nightmap {

struct TilesOptions {
  OPTION(double, edge_m, 24.0, {1.0, 1000.0}, "edge of a tile");
  OPTION(double, overlap_m, 0.5, {0.0, 10.0},
         "width of the border around a tile whose points are also fused, for neighbourhoods at its "
         "edge");
  OPTION(double, max_range_m, 4.0, {0.1, 100.0},
         "depth up to which keyframes are listed; at least that of point_cloud and octree");
  REGISTER_OPTIONS();
};

// Column and row of a tile. Its centre is at (column, row) * edge_m, so that a small building
// around the map's origin is one tile. Appended frames move no tile.
using TileIndex = std::pair<int, int>;
std::string TileName(const TileIndex& index);  // "0_0", "-1_2"

// The tiles that a keyframe may see up to a depth of max_range_m, each with those keyframes in
// their order. Every measured point lies in exactly one of the tiles. Throws InputError when a
// pose is too far from the origin, or a camera sees more than 87 degrees off its axis.
std::map<TileIndex, Tile> RunTiles(const TilesOptions& options,
                                   const std::vector<RgbdCamera>& cameras,
                                   const std::vector<Keyframe>& keyframes);

}  // namespace nightmap
