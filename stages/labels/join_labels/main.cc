// SPDX-License-Identifier: Apache-2.0
// join_labels: reads the labelled voxels of all tiles, the octree and the cloud; writes the voxels
// of the building, and octree and cloud with their classes.
#include "pipeline/program/stage_main.h"
#include "stages/labels/join_labels/write_joined_labels.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "join_labels",
      "joins the labelled voxels of all tiles, and colors octree and cloud by class",
      {{"tile", "tile_X_Y.json of the tiles stage", Arity::kMany},
       {"tile_labels", "tile_X_Y.h5 of the same tiles, in order", Arity::kMany},
       {"tile_report", "report_X_Y.json of the same labels, in order", Arity::kMany},
       {"octree", "map.ot of the join_octrees stage"},
       {"cloud", "cloud.ply of the join_clouds stage"}},
      {{"ot",
        "map.ot: log-odds, and the color of the class of each voxel (OctoMap ColorOcTree); "
        "voxels.h5, the votes, is written next to it"},
       {"legend", "names and colors of the classes, and how many voxels each has"},
       {"cloud", "cloud.ply: as the cloud, with the class of each point as its label"}}};
  return StageMain(argc, argv, spec, JoinLabelsOptions{}, WriteJoinedLabels);
}
