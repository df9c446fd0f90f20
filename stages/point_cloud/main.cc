// SPDX-License-Identifier: Apache-2.0
// point_cloud: fuses the depth of the keyframes. Reads the list of one tile and its frames' pixels
// and writes the cloud of the tile; or reads the clouds of all tiles and writes cloud.ply.
#include "stages/point_cloud/point_cloud.h"

#include "pipeline/base/stage_main.h"
#include "stages/point_cloud/join_tiles.h"
#include "stages/point_cloud/report_tile.h"

namespace nightmap {
namespace {

void MapTile(const PointCloudOptions& options, StageContext& context) {
  if (context.Inputs("tile").size() != 1 || !context.HasInput("cameras") ||
      !context.HasInput("data")) {
    throw UsageError(
        "--out tile_cloud needs one --in tile=PATH, --in cameras=PATH and --in data=PATH");
  }
  const KeyframeSource source = OpenTile(context.Input("tile"),
                                         context.Input("cameras"),
                                         context.Input("data"),
                                         options.keyframe_stride,
                                         options.max_depth_m);
  const auto result = RunPointCloud(options, source, context.GetProgress(), context.NumThreads());
  WritePly(context.Output("tile_cloud"), result.points);
  context.Report()["num_keyframes_listed"] = source.keyframes.size();
  ReportTile(result, context);
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "point_cloud",
      "fuses the depth of all keyframes to one point cloud in the map frame",
      {{"tile", "tile_X_Y.json of the tiles stage", Arity::kMany},
       {"cameras", "cameras.json of the tiles stage, for one tile", Arity::kOptional},
       FolderPort("data", "folder the frames' paths are relative to", Arity::kOptional),
       {"tile_cloud", "tile_X_Y.ply of all tiles, to join", Arity::kAnyNumber},
       {"tile_report", "their report_X_Y.json", Arity::kAnyNumber}},
      {{"tile_cloud", "tile_X_Y.ply: the part of the cloud in one tile", Arity::kOptional},
       {"cloud", "cloud.ply: position, normal, color and label of each point", Arity::kOptional}}};
  return StageMain(argc,
                   argv,
                   spec,
                   PointCloudOptions{},
                   [](const PointCloudOptions& options, StageContext& context) {
                     if (context.HasOutput("tile_cloud") == context.HasOutput("cloud")) {
                       throw UsageError("give either --out tile_cloud=PATH or --out cloud=PATH");
                     }
                     context.HasOutput("cloud") ? JoinTiles(options, context)
                                                : MapTile(options, context);
                   });
}
