// SPDX-License-Identifier: Apache-2.0
// moving: reads the frames of one shard and their pixels; writes masks of what moves in them.
#include <opencv2/core/utility.hpp>

#include "pipeline/base/files.h"
#include "pipeline/io/frame_reader.h"
#include "pipeline/program/stage_main.h"
#include "stages/labels/moving/moving.h"
#include "stages/labels/moving/moving_output.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  cv::setNumThreads(1);  // frames are the unit of parallelism
  const StageSpec spec{
      "moving",
      "Masks what moves in the frames of a shard, found by depth and motion.",
      {{"frames", "shard_NNNN.csv of the frames stage"},
       {"cameras", "cameras.json of the frames stage"},
       FolderPort("data", "folder to which the paths in the frames file are relative"),
       {"may_move", "masks of what labels say may move", Arity::kOptional}},
      {{"masks", "masks of what moves"}, {"frames", "the list of frames, with these masks"}}};
  return StageMain(argc, argv, spec, MovingOptions{}, [](const auto& options, auto& context) {
    MovingInput input;
    input.frames = ReadFrames(context.Input("frames"));
    input.cameras = ReadCameras(context.Input("cameras"), input.frames);
    const FrameReader reader(context.Input("data"), context.Inputs("may_move"));
    input.load = [&, data_root = context.Input("data")](const FrameRecord& frame) {
      const RgbdCamera& camera = input.cameras.at(static_cast<std::size_t>(frame.camera_idx));
      auto images = LoadRgbd(frame, camera, data_root);
      images.moving = reader.Mask(frame, camera);
      return images;
    };
    const auto result = RunMoving(options, input, context.GetProgress(), context.NumThreads());
    for (const std::string& reason : result.skipped) context.Skip(reason);
    context.CheckSkipped(input.frames.size(), options.max_failed_ratio);
    WriteMasks(context.Output("masks"), MasksOf(result), context.ConfigToml());
    const std::string masks = context.FinalPath("masks").filename().string();
    WriteFile(context.Output("frames"), FramesToCsv(FramesWithMasks(input.frames, result, masks)));
    context.Report().update(Summarize(result));
  });
}
