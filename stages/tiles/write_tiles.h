// SPDX-License-Identifier: Apache-2.0
// The files of the tiles stage.
#pragma once

#include <map>
#include <vector>

#include "pipeline/program/stage_main.h"
#include "stages/tiles/tiles.h"

namespace nightmap {

// Writes cameras.json and tile_X_Y.json beside the output `tiles`, each kept as it is when its
// bytes did not change, and tiles.txt, the names X_Y of the tiles in order. Removes the lists of
// tiles that no keyframe sees any more.
void WriteTiles(const std::vector<RgbdCamera>& cameras,
                const std::map<TileIndex, Tile>& tiles,
                StageContext& context);

}  // namespace nightmap
