// SPDX-License-Identifier: Apache-2.0
// features: reads the frames of one shard and their pixels; writes keypoints, descriptors, depths.
// With a model it also writes what can move in the frames.
#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <optional>

#include "pipeline/io/frame_reader.h"
#include "pipeline/program/stage_main.h"
#include "stages/camera/features/features.h"
#include "stages/camera/features/features_report.h"

namespace {

using namespace nightmap;

StageSpec Spec() {
  PortSpec model = CheckedPort(
      "model", "TOML file: classes, and a network in ONNX, of what can move", CheckModel);
  model.arity = Arity::kOptional;
  return {"features",
          "Describes keypoints in some frames of a shard, and tracks them through the others.",
          {{"frames", "shard_NNNN.csv of the frames stage"},
           {"cameras", "cameras.json of the frames stage"},
           FolderPort("data", "folder to which the paths in the frames file are relative"),
           model,
           {"masks", "masks of what moves in these frames", Arity::kOptional}},
          {{"features", "shard_NNNN.h5: keypoints, descriptors, depths"},
           {"labels", "labels of the frames that were labelled", Arity::kOptional},
           {"masks", "masks of what can move in them", Arity::kOptional},
           {"frames", "the list of frames, with these masks", Arity::kOptional}}};
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);  // segments are the unit of parallelism
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);  // errors are ours
  return StageMain(argc, argv, Spec(), FeaturesOptions{}, [](const auto& options, auto& context) {
    FeaturesInput input;
    input.frames = ReadFrames(context.Input("frames"));
    input.cameras = WithoutMaxDepth(ReadCameras(context.Input("cameras"), input.frames));
    const FrameReader reader(context.Input("data"), context.Inputs("masks"));
    input.load = [&](const FrameRecord& frame) {
      return reader.Rgbd(frame, input.cameras.at(static_cast<std::size_t>(frame.camera_idx)));
    };
    std::optional<LabelledFrames> labelled;
    if (context.HasInput("model"))
      labelled.emplace(MakeLabelledFrames(input.frames, input.cameras, context));
    if (labelled) input.labelled = &*labelled;
    const auto result = RunFeatures(options, input, context.GetProgress(), context.NumThreads());
    for (const std::string& reason : result.skipped) context.Skip(reason);
    context.CheckSkipped(input.frames.size(), options.max_failed_ratio);
    WriteFeatures(context.Output("features"), result.shard, context.ConfigToml());
    context.Report().update(Summarize(result.shard));
    if (labelled) labelled->Write(context);
  });
}
