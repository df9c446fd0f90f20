// SPDX-License-Identifier: Apache-2.0
// survey: reads a sample of the frames of all shards and their pixels; writes what they are like,
// and next to it a mask for each camera that sees a part of the robot.
#include "stages/camera/survey/survey.h"

#include <limits>
#include <opencv2/core/utility.hpp>

#include "pipeline/base/files.h"
#include "pipeline/program/stage_main.h"
#include "stages/camera/survey/survey_output.h"

namespace nightmap {
namespace {

// The cut at a camera's range tells of wrong units.
std::vector<RgbdCamera> WithoutRange(std::vector<RgbdCamera> cameras) {
  for (RgbdCamera& camera : cameras) {
    camera.min_depth_m = 0;
    camera.max_depth_m = std::numeric_limits<double>::infinity();
  }
  return cameras;
}

void Run(const SurveyOptions& options, StageContext& context) {
  SurveyInput input;
  input.frames = ReadFrames(context.Inputs("frames"));
  input.cameras = WithoutRange(ReadCameras(context.Input("cameras"), input.frames));
  input.load = [&, data_root = context.Input("data")](const FrameRecord& frame) {
    return LoadRgbd(frame, input.cameras.at(static_cast<std::size_t>(frame.camera_idx)), data_root);
  };
  const SurveyResult result =
      RunSurvey(options, input, context.GetProgress(), context.NumThreads());
  for (const std::string& reason : result.skipped) context.Skip(reason);
  context.CheckSkipped(result.num_sampled, options.max_failed_ratio);
  WriteFile(context.Output("frames"), SurveyToCsv(result, input.frames));
  WriteMasks(result.fixed_parts, input.cameras, context);
  context.Report().update(Summarize(result, input.frames, input.cameras));
}

}  // namespace
}  // namespace nightmap

int main(int argc, char** argv) {
  using namespace nightmap;
  cv::setNumThreads(1);  // windows of frames are the unit of parallelism
  const StageSpec spec{
      "survey",
      "Measures exposure, sharpness, texture, depth and order of recorded frames.",
      {{"frames", "shard_NNNN.csv of all shards, in order", Arity::kMany},
       {"cameras", "cameras.json of the frames stage"},
       FolderPort("data", "folder to which the paths in the frames files are relative")},
      {{"frames",
        "frames.csv: what each surveyed frame is like; mask_N.png are written next to it"}}};
  return StageMain(argc, argv, spec, SurveyOptions{}, Run);
}
