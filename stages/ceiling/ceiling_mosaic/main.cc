// SPDX-License-Identifier: Apache-2.0
// ceiling_mosaic: reads frames, their pixels, trajectory and map of a ceiling; writes its picture.
#include "pipeline/ceiling/ceiling_files.h"
#include "pipeline/io/frame_reader.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/program/stage_main.h"
#include "stages/ceiling/ceiling_mosaic/ceiling_mosaic.h"
#include "stages/ceiling/ceiling_mosaic/choose_views.h"
#include "stages/ceiling/ceiling_mosaic/mosaic_files.h"

namespace nightmap {
namespace {

void Run(const CeilingMosaicOptions& options, StageContext& context) {
  const std::vector<FrameRecord> frames = ReadFrames(context.Inputs("frames"));
  const RgbdCamera camera = OneCamera(frames, ReadCameras(context.Input("cameras"), frames));
  const CeilingMap map = ReadCeilingMap(context.Input("map"));
  const FrameReader reader(context.Input("data"));
  CeilingMosaicInput input;
  input.camera = camera.color;
  input.views = ChooseViews(
      frames, ReadPoses(context.Input("trajectory")), MountedAs(camera.robot_from_camera, map));
  for (const CeilingLandmark& landmark : map.landmarks) {
    input.landmarks.push_back(landmark.position_m);
  }
  input.load = [&](std::size_t frame) { return reader.Color(frames[frame], camera); };
  const CeilingMosaic mosaic =
      RunCeilingMosaic(options, input, context.GetProgress(), context.NumThreads());
  for (const std::string& reason : mosaic.skipped) context.Skip(reason);
  context.CheckSkipped(input.views.size(), options.max_failed_ratio);
  WritePng(context.Output("png"), mosaic.picture);
  WriteFile(context.Output("pgw"), MosaicToWorldFile(mosaic));
  WriteFile(context.Output("yaml"), MosaicToYaml(mosaic, "mosaic.png"));
  context.Report().update({{"num_views", input.views.size()},
                           {"width_px", mosaic.picture.width},
                           {"height_px", mosaic.picture.height},
                           {"covered_m2", mosaic.covered_m2},
                           {"median_deviation", mosaic.median_deviation}});
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  const StageSpec spec{
      "ceiling_mosaic",
      "Makes one picture of the whole ceiling, to the scale of the map.",
      {{"frames", "shard_NNNN.csv of all shards, in order", Arity::kMany},
       {"cameras", "cameras.json of the frames stage"},
       FolderPort("data", "folder to which the paths in the frames file are relative"),
       {"trajectory", "trajectory.tum: map_from_robot at each frame"},
       {"map", "ceiling_map.h5 of ceiling_adjust or ceiling_ekf"}},
      {{"png", "mosaic.png: x is right, y is up; black where nothing was seen"},
       {"pgw", "mosaic.pgw: its place in the map, as a world file"},
       {"yaml", "mosaic.yaml: the same as in maps of floors"}}};
  return StageMain(argc, argv, spec, CeilingMosaicOptions{}, Run);
}
