// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/landmarks/read_inputs.h"

#include "pipeline/camera/leave_out.h"
#include "pipeline/io/trajectory_io.h"

namespace nightmap {

LandmarksInput ReadLandmarksInput(const VocabularyTree& tree, const StageContext& context) {
  const auto frames = ReadFrames(context.Inputs("frames"));
  LandmarksInput input{frames,
                       ReadCameras(context.Input("cameras"), frames),
                       ReadFeatures(context.Inputs("features"), context.Inputs("frames")),
                       &tree,
                       ReadPoses(context.Input("trajectory")),
                       ReadPoses(context.Input("keyframes"))};
  CheckFeaturesOfFrames(input.frames, input.features);
  if (context.HasInput("masked_frames") != context.HasInput("masks")) {
    throw UsageError("give both --in masked_frames=PATH and --in masks=PATH, or neither");
  }
  if (context.HasInput("masked_frames")) {
    LeaveOut(ReadFrames(context.Input("masked_frames")),
             input.cameras,
             FrameReader({}, context.Inputs("masks")),
             &input.features);
  }
  return input;
}

}  // namespace nightmap
