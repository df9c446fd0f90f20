// SPDX-License-Identifier: Apache-2.0
// tiles: lists the keyframes that may see each part of the building. Reads the frames, cameras and
// keyframes.tum; writes tiles.txt and, next to it, tile_X_Y.json and the cameras.
#include "pipeline/dense/rgbd_keyframes.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/program/stage_main.h"
#include "stages/dense/tiles/tiles.h"
#include "stages/dense/tiles/write_tiles.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{"tiles",
                       "lists the keyframes that may see each tile of the building",
                       {{"frames", "shard_NNNN.csv of the frames stage", Arity::kMany},
                        {"cameras", "cameras.json of the adjust stage"},
                        {"keyframes", "keyframes.tum of the map_frame stage, map_from_camera"}},
                       {{"tiles", "tiles.txt; the other files are written next to it"}}};
  return StageMain(
      argc, argv, spec, TilesOptions{}, [](const TilesOptions& options, StageContext& context) {
        const auto frames = ReadFrames(context.Inputs("frames"));
        const auto cameras = ReadCameras(context.Input("cameras"), frames);
        const auto keyframes =
            SelectKeyframes(frames, cameras, ReadPoses(context.Input("keyframes")), 1);
        if (keyframes.empty()) {
          throw DataError("{}: no keyframe with depth: nothing can be mapped",
                          context.Input("keyframes").string());
        }
        const auto tiles = RunTiles(options, cameras, keyframes);
        WriteTiles(cameras, tiles, context);
        context.Report()["num_keyframes"] = keyframes.size();
        context.Report()["num_tiles"] = tiles.size();
      });
}
