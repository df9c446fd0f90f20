// SPDX-License-Identifier: Apache-2.0
// octree: reads the list of one tile, the pixels of its keyframes and the clouds in and around it;
// casts the depth rays into the occupancy octree of the tile.
#include "pipeline/program/stage_main.h"
#include "stages/octree/octree_of_tiles.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "octree",
      "marks the space of a tile as occupied, free or unknown",
      {{"tile", "tile_X_Y.json of the tiles stage"},
       {"cameras", "cameras.json of the tiles stage"},
       FolderPort("data", "folder to which the frames' paths are relative"),
       {"cloud", "tile_X_Y.ply of the tile and its neighbours", Arity::kAnyNumber}},
      {{"tile_ot", "tile_X_Y.ot: the part of the octree in one tile"}}};
  return StageMain(argc, argv, spec, OctreeOptions{}, MapOctreeTile);
}
