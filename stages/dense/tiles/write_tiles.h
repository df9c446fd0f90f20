// SPDX-License-Identifier: Apache-2.0
// The files of the tiles stage.
#pragma once

#include <map>
#include <vector>

#include "pipeline/program/stage_main.h"
#include "stages/dense/tiles/tiles.h"

namespace nightmap {

// Writes cameras.json and tile_X_Y.json next to the output `tiles`, and tiles.txt with the names
// X_Y of the tiles in order. A file whose bytes did not change is left untouched. Removes the lists
// of tiles that no keyframe sees any more.
void WriteTiles(const std::vector<RgbdCamera>& cameras,
                const std::map<TileIndex, Tile>& tiles,
                StageContext& context);

}  // namespace nightmap
