// SPDX-License-Identifier: Apache-2.0
// octree: casts the keyframes' depth rays into an occupancy octree. Reads the list of one tile, its
// frames' pixels and the clouds in and around it, and writes the octree of the tile; or reads the
// octrees of all tiles and writes map.ot and map.bt.
#include "pipeline/base/stage_main.h"
#include "stages/octree/octree_of_tiles.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "octree",
      "marks the space of the building occupied, free or unknown",
      {{"tile", "tile_X_Y.json of the tiles stage", Arity::kMany},
       {"cameras", "cameras.json of the tiles stage, for one tile", Arity::kOptional},
       FolderPort("data", "folder the frames' paths are relative to", Arity::kOptional),
       {"cloud", "tile_X_Y.ply of the tile and its neighbours", Arity::kAnyNumber},
       {"tile_ot", "tile_X_Y.ot of all tiles, to join", Arity::kAnyNumber},
       {"tile_report", "their report_X_Y.json", Arity::kAnyNumber}},
      {{"tile_ot", "tile_X_Y.ot: the part of the octree in one tile", Arity::kOptional},
       {"ot", "map.ot: log-odds and color of each voxel (OctoMap ColorOcTree)", Arity::kOptional},
       {"bt", "map.bt: occupied or free (OctoMap binary)", Arity::kOptional}}};
  return StageMain(
      argc, argv, spec, OctreeOptions{}, [](const OctreeOptions& options, StageContext& context) {
        if (context.HasOutput("tile_ot") == context.HasOutput("ot") ||
            context.HasOutput("ot") != context.HasOutput("bt")) {
          throw UsageError("give either --out tile_ot=PATH, or --out ot=PATH and --out bt=PATH");
        }
        context.HasOutput("ot") ? JoinOctreeTiles(options, context)
                                : MapOctreeTile(options, context);
      });
}
