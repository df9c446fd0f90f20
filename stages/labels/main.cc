// SPDX-License-Identifier: Apache-2.0
// labels: reads frames and their pixels; writes the labels of some of them, the masks of what can
// move in these, and the frames with their masks.
#include <malloc.h>

#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>

#include "pipeline/io/masks_io.h"
#include "pipeline/program/stage_main.h"
#include "stages/labels/frame_labeller.h"
#include "stages/labels/labels.h"
#include "stages/labels/report_labels.h"

int main(int argc, char** argv) {
  using namespace nightmap;
  cv::setNumThreads(1);  // frames are the unit of parallelism; with more, sums would differ
  // Keeps the pages of freed pictures: handing them back and forth took a tenth of the time.
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);  // errors are ours
  const StageSpec spec{
      "labels",
      "Labels the pixels of some frames, and masks what can move by itself.",
      {{"frames", "shard_NNNN.csv of the frames stage, or queries.csv"},
       {"cameras", "cameras.json of the frames stage, or query_cameras.json"},
       FolderPort("data", "folder to which the paths in the list of frames are relative"),
       CheckedPort("model", "TOML file: classes, and a network in ONNX", CheckModel)},
      {{"labels", "labels with confidences"},
       {"masks", "masks of what can move by itself"},
       {"frames", "the list of frames, with the masks of those that were labelled"}}};
  return StageMain(argc, argv, spec, LabelsOptions{}, [](const auto& options, auto& context) {
    const SegmentationModel model = ReadSegmentationModel(context.Input("model"));
    if (model.HasNetwork()) context.AddInput(model.network, context.Input("model"));
    auto frames = ReadFrames(context.Input("frames"));
    LabelsInput input{.frames = frames,
                      .chosen = FramesToLabel(options, model, frames),
                      .cameras = ReadCameras(context.Input("cameras"), frames),
                      .classes = {model.classes, model.moving, model.palette}};
    const std::filesystem::path data_root = context.Input("data");
    input.label = MakeLabeller(model, input.cameras, data_root);
    if (model.HasNetwork()) input.color = MakeColorReader(input.cameras, data_root);
    const LabelsResult result =
        RunLabels(options, input, context.NumThreads(), context.GetProgress());
    for (const std::string& reason : result.skipped) context.Skip(reason);
    context.CheckSkipped(result.num_to_label, options.max_failed_ratio);
    WriteLabels(context.Output("labels"), {input.classes, result.frames}, context.ConfigToml());
    WriteMasks(context.Output("masks"), result.masks, context.ConfigToml());
    NameMasks(result.masks, context.FinalPath("masks").filename().string(), &frames);
    WriteFile(context.Output("frames"), FramesToCsv(frames));
    ReportLabels(result, input.classes, frames.size(), &context.Report());
  });
}
