// SPDX-License-Identifier: Apache-2.0
// join_octrees: reads the octrees of all tiles and writes map.ot and map.bt.
#include "pipeline/program/stage_main.h"
#include "stages/dense/join_octrees/join_octrees.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "join_octrees",
      "joins the octrees of all tiles into one of the building",
      {{"tile", "tile_X_Y.json of the tiles stage", Arity::kMany},
       {"tile_ot", "tile_X_Y.ot of the same tiles, in order", Arity::kMany},
       {"tile_report", "report_X_Y.json of the same octrees, in order", Arity::kMany}},
      {{"ot", "map.ot: log-odds and color of each voxel (OctoMap ColorOcTree)"},
       {"bt", "map.bt: occupied or free (OctoMap binary)"}}};
  return StageMain(argc, argv, spec, JoinOctreesOptions{}, JoinOctreeFiles);
}
