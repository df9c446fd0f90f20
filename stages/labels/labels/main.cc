// SPDX-License-Identifier: Apache-2.0
// labels: reads frames and their pixels; writes their labels, the masks of what can move in them,
// and the frames with their masks.
#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>

#include "pipeline/program/stage_main.h"
#include "stages/labels/labels/labels.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  cv::setNumThreads(1);  // frames are the unit of parallelism; with more, sums would differ
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);  // errors are ours
  const StageSpec spec{
      "labels",
      "Labels the pixels of pictures, and masks what can move by itself.",
      {{"frames", "queries.csv, or shard_NNNN.csv of the frames stage"},
       {"cameras", "query_cameras.json, or cameras.json of the frames stage"},
       FolderPort("data", "folder to which the paths in the list of frames are relative"),
       CheckedPort("model", "TOML file: classes, and a network in ONNX", CheckModel)},
      {{"labels", "labels with confidences"},
       {"masks", "masks of what can move by itself"},
       {"frames", "the list of frames, with the masks of those that were labelled"}}};
  return StageMain(argc, argv, spec, LabelsOptions{}, [](const auto& options, auto& context) {
    const auto frames = ReadFrames(context.Input("frames"));
    const auto cameras = ReadCameras(context.Input("cameras"), frames);
    const std::filesystem::path data_root = context.Input("data");
    LabelledFrames labelled = MakeLabelledFrames(frames, cameras, context);
    const auto load = [&](const FrameRecord& frame) {
      return LoadRgbd(frame, cameras.at(static_cast<std::size_t>(frame.camera_idx)), data_root);
    };
    const LabelsResult result =
        RunLabels(frames, load, &labelled, context.GetProgress(), context.NumThreads());
    for (const std::string& reason : result.skipped) context.Skip(reason);
    context.CheckSkipped(result.num_to_label, options.max_failed_ratio);
    labelled.Write(context);
  });
}
