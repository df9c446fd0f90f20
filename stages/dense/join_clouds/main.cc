// SPDX-License-Identifier: Apache-2.0
// join_clouds: reads the clouds of all tiles and writes cloud.ply.
#include "pipeline/program/stage_main.h"
#include "stages/dense/join_clouds/write_joined_cloud.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "join_clouds",
      "joins the clouds of all tiles into one point cloud in the map frame",
      {{"tile", "tile_X_Y.json of the tiles stage", Arity::kMany},
       {"tile_cloud", "tile_X_Y.ply of the same tiles, in order", Arity::kMany},
       {"tile_report", "report_X_Y.json of the same clouds, in order", Arity::kMany}},
      {{"cloud", "cloud.ply: position, normal, color and label of each point"}}};
  return StageMain(argc, argv, spec, JoinCloudsOptions{}, WriteJoinedCloud);
}
