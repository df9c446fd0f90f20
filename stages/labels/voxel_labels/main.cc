// SPDX-License-Identifier: Apache-2.0
// voxel_labels: reads the list and the octree of one tile, and depth and labels of its keyframes;
// writes how much they speak for each class in each occupied voxel.
#include "pipeline/program/stage_main.h"
#include "stages/labels/voxel_labels/voxel_labels.h"

namespace nightmap {
namespace {

void Run(const VoxelLabelsOptions& options, StageContext& context) {
  context.BeginPart("open");
  const KeyframeSource source = OpenTile(context, options.keyframe_stride, options.max_range_m);
  const FrameLabels labels(context.Inputs("labels"));
  const OccupiedVoxels occupied =
      ReadOccupiedVoxels(context.Input("tile_ot"),
                         context.Inputs("near_ot"),
                         source.region.inside.Grown(source.region.overlap_m));
  context.BeginPart("vote");
  const VoxelLabelsResult result = RunVoxelLabels(options,
                                                  source,
                                                  LoaderOf(labels, source.cameras),
                                                  labels.Classes(),
                                                  occupied,
                                                  context.GetProgress(),
                                                  context.NumThreads());
  for (const std::string& reason : result.skipped) context.Skip(reason);
  context.BeginPart("write");
  WriteVoxelLabels(context.Output("tile_labels"), result.voxels, context.ConfigToml());
  context.Report().update(Summarize(source, occupied, result));
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "voxel_labels",
      "gives the occupied voxels of a tile the classes that keyframes saw there",
      {{"tile", "tile_X_Y.json of the tiles stage"},
       {"cameras", "cameras.json of the tiles stage"},
       FolderPort("data", "folder to which the frames' paths are relative"),
       {"masks",
        "shard_NNNN.h5 of masks: what moves in the frames",
        Arity::kAnyNumber,
        PortKind::kByHash},
       {"labels", "labels_NNNN.h5: labels of the frames", Arity::kMany, PortKind::kByHash},
       {"tile_ot", "tile_X_Y.ot of the octree stage"},
       {"near_ot", "tile_X_Y.ot of the tile and its neighbours", Arity::kAnyNumber}},
      {{"tile_labels", "tile_X_Y.h5: votes for each class in each occupied voxel"}}};
  return StageMain(argc, argv, spec, VoxelLabelsOptions{}, Run);
}
