// SPDX-License-Identifier: Apache-2.0
// octree: reads the list of one tile, the pixels of its keyframes and the clouds in and around it;
// casts the depth rays into the occupancy octree of the tile.
#include <optional>

#include "pipeline/program/stage_main.h"
#include "stages/dense/octree/octree_of_tiles.h"

namespace nightmap {
namespace {

void Run(const OctreeOptions& options, StageContext& context) {
  context.BeginPart("open");
  const KeyframeSource source = OpenTile(context, options.keyframe_stride, options.max_range_m);
  std::optional<std::vector<CloudPoint>> cloud;
  if (context.HasInput("cloud")) {
    cloud = ReadCloudAround(context.Inputs("cloud"), source.region.inside, options);
  }
  context.BeginPart("cast");
  const OctreeResult result = RunOctreeTile(
      options, source, cloud ? &*cloud : nullptr, context.GetProgress(), context.NumThreads());
  for (const std::string& reason : result.skipped) context.Skip(reason);
  context.BeginPart("write");
  WriteOctree(context.Output("tile_ot"), result.tree);
  context.Report()["num_keyframes_listed"] = source.keyframes.size();
  context.Report()["num_rays"] = result.num_rays;
  context.Report()["num_unsupported"] = result.num_unsupported;
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "octree",
      "marks the space of a tile as occupied, free or unknown",
      {{"tile", "tile_X_Y.json of the tiles stage"},
       {"cameras", "cameras.json of the tiles stage"},
       FolderPort("data", "folder to which the frames' paths are relative"),
       {"masks",
        "shard_NNNN.h5 of masks: what moves in the frames",
        Arity::kAnyNumber,
        PortKind::kByHash},
       {"cloud", "tile_X_Y.ply of the tile and its neighbours", Arity::kAnyNumber}},
      {{"tile_ot", "tile_X_Y.ot: the part of the octree in one tile"}}};
  return StageMain(argc, argv, spec, OctreeOptions{}, Run);
}
