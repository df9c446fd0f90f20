// SPDX-License-Identifier: Apache-2.0
// point_cloud: reads the list of one tile and the pixels of its keyframes; fuses their depth into
// the cloud of the tile.
#include "stages/dense/point_cloud/point_cloud.h"

#include "pipeline/program/stage_main.h"
#include "stages/dense/point_cloud/report_tile.h"

namespace nightmap {
namespace {

void Run(const PointCloudOptions& options, StageContext& context) {
  const KeyframeSource source = OpenTile(context, options.keyframe_stride, options.max_depth_m);
  const auto result = RunPointCloud(options, source, context.GetProgress(), context.NumThreads());
  WritePly(context.Output("tile_cloud"), result.points);
  WriteFile(context.Output("places"), PlacesToCsv(result.places));
  context.Report()["num_keyframes_listed"] = source.keyframes.size();
  ReportTile(result, context);
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{"point_cloud",
                       "fuses the depth of a tile's keyframes to a point cloud in the map frame",
                       {{"tile", "tile_X_Y.json of the tiles stage"},
                        {"cameras", "cameras.json of the tiles stage"},
                        FolderPort("data", "folder to which the frames' paths are relative"),
                        {"masks",
                         "shard_NNNN.h5 of masks: what moves in the frames",
                         Arity::kAnyNumber,
                         PortKind::kByHash}},
                       {{"tile_cloud", "tile_X_Y.ply: the part of the cloud in one tile"},
                        {"places", "places_X_Y.csv: quality of that part by place"}}};
  return StageMain(argc, argv, spec, PointCloudOptions{}, Run);
}
