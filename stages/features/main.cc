// SPDX-License-Identifier: Apache-2.0
// features: reads the frames of one shard and their pixels; writes keypoints, descriptors, depths.
#include <opencv2/core/utility.hpp>

#include "pipeline/io/frame_reader.h"
#include "pipeline/program/stage_main.h"
#include "stages/features/features.h"
#include "stages/features/features_report.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  cv::setNumThreads(1);  // segments are the unit of parallelism
  const StageSpec spec{
      "features",
      "Describes keypoints in some frames of a shard, and tracks them through the others.",
      {{"frames", "shard_NNNN.csv of the frames stage"},
       {"cameras", "cameras.json of the frames stage"},
       FolderPort("data", "folder to which the paths in the frames file are relative"),
       {"masks",
        "shard_NNNN.h5 of masks; a frame without one is not described",
        Arity::kAnyNumber}},
      {{"features", "shard_NNNN.h5: keypoints, descriptors, depths"}}};
  return StageMain(argc, argv, spec, FeaturesOptions{}, [](const auto& options, auto& context) {
    const FrameReader reader(context.Input("data"), context.Inputs("masks"));
    FeaturesInput input;
    input.frames = ReadFrames(context.Input("frames"));
    input.cameras = ReadCameras(context.Input("cameras"), input.frames);
    for (const FrameRecord& frame : input.frames) {
      input.may_describe.push_back(reader.MayUse(frame));
    }
    input.load = [&](const FrameRecord& frame) {
      return reader.Rgbd(frame, input.cameras.at(static_cast<std::size_t>(frame.camera_idx)));
    };
    const auto result = RunFeatures(options, input, context.NumThreads(), context.GetProgress());
    for (const std::string& reason : result.skipped) context.Skip(reason);
    context.CheckSkipped(input.frames.size(), options.max_failed_ratio);
    WriteFeatures(context.Output("features"), result.shard, context.ConfigToml());
    context.Report().update(Summarize(result.shard));
  });
}
