// SPDX-License-Identifier: Apache-2.0
// labels: reads the frames of one shard and their pixels; writes the labels of some of them.
#include "stages/labels/labels.h"

#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>

#include "pipeline/labels/segmenter.h"
#include "pipeline/program/stage_main.h"
#include "stages/labels/report_labels.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  cv::setNumThreads(1);  // frames are the unit of parallelism; with more, sums would differ
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);  // errors are ours
  const StageSpec spec{
      "labels",
      "Labels the pixels of some frames of a shard with a segmentation network.",
      {{"frames", "shard_NNNN.csv of the frames stage"},
       {"cameras", "cameras.json of the frames stage"},
       FolderPort("data", "folder to which the paths in the frames file are relative"),
       CheckedPort("model",
                   "TOML file that describes a network in ONNX",
                   [](const auto& path) { Segmenter{ReadSegmentationModel(path)}; })},
      {{"labels", "shard_NNNN.h5: label pictures with confidences"}}};
  return StageMain(argc, argv, spec, LabelsOptions{}, [](const auto& options, auto& context) {
    const SegmentationModel model = ReadSegmentationModel(context.Input("model"));
    context.AddInput(model.network, context.Input("model"));
    const LabelClasses classes{model.classes, model.moving, model.palette};
    const Segmenter segmenter(model);
    const auto frames = ReadFrames(context.Input("frames"));
    const auto cameras = ReadCameras(context.Input("cameras"), frames);
    const auto& data = context.Input("data");
    const FrameLabeller label = [&](const FrameRecord& frame) {
      const RgbdCamera& camera = cameras.at(static_cast<std::size_t>(frame.camera_idx));
      const bool has_depth = !frame.depth.path.empty();
      const ColorImage color = LoadColor(frame, camera, data);
      return segmenter.Segment(color, has_depth ? LoadDepth(frame, camera, data) : DepthImage{});
    };
    const auto result =
        RunLabels(options, frames, classes, label, context.NumThreads(), context.GetProgress());
    for (const std::string& reason : result.skipped) context.Skip(reason);
    context.CheckSkipped(result.num_to_label, options.max_failed_ratio);
    WriteLabels(context.Output("labels"), {classes, result.frames}, context.ConfigToml());
    ReportLabels(result, classes, frames.size(), &context.Report());
  });
}
