// SPDX-License-Identifier: Apache-2.0
// features: reads the frames of one shard and their pixels; writes keypoints, descriptors, depths.
#include "stages/features/features.h"

#include <opencv2/core/utility.hpp>

#include "pipeline/program/stage_main.h"

namespace nightmap {
namespace {

void Summarize(const FeaturesShard& shard, nlohmann::json* report) {
  int num_features = 0;
  int num_with_depth = 0;
  int num_empty_frames = 0;
  int num_described = 0;
  for (const FrameFeatures& frame : shard.frames) {
    num_features += frame.NumFeatures();
    num_with_depth += static_cast<int>(
        std::ranges::count_if(frame.depths_m, [](float depth_m) { return depth_m > 0; }));
    num_empty_frames += frame.NumFeatures() == 0;
    num_described += frame.IsDescribed();
  }
  (*report)["num_frames"] = shard.frames.size();
  (*report)["num_described_frames"] = num_described;
  (*report)["num_features"] = num_features;
  (*report)["num_features_with_depth"] = num_with_depth;
  (*report)["num_frames_without_features"] = num_empty_frames;
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  cv::setNumThreads(1);  // segments are the unit of parallelism
  const StageSpec spec{
      "features",
      "Describes keypoints in some frames of a shard, and tracks them through the others.",
      {{"frames", "shard_NNNN.csv of the frames stage"},
       {"cameras", "cameras.json of the frames stage"},
       FolderPort("data", "folder to which the paths in the frames file are relative")},
      {{"features", "shard_NNNN.h5: keypoints, descriptors, depths"}}};
  return StageMain(argc, argv, spec, FeaturesOptions{}, [](const auto& options, auto& context) {
    const auto frames = ReadFrames(context.Input("frames"));
    const auto cameras = ReadCameras(context.Input("cameras"), frames);
    const RgbdLoader load = [&](const FrameRecord& frame) {
      const RgbdCamera& camera = cameras.at(static_cast<std::size_t>(frame.camera_idx));
      return LoadRgbd(frame, camera, context.Input("data"));
    };
    const auto result =
        RunFeatures(options, frames, cameras, load, context.NumThreads(), context.GetProgress());
    for (const std::string& reason : result.skipped) context.Skip(reason);
    context.CheckSkipped(frames.size(), options.max_failed_ratio);
    WriteFeatures(context.Output("features"), result.shard, context.ConfigToml());
    Summarize(result.shard, &context.Report());
  });
}
