// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/landmarks/read_inputs.h"

#include "pipeline/camera/leave_out.h"
#include "pipeline/io/trajectory_io.h"

namespace nightmap {
namespace {

// Beside them, regions hold copies of theirs.
constexpr std::size_t kMaxFeatures_bytes = std::size_t{512} << 20;

}  // namespace

LandmarksInput ReadLandmarksInput(const VocabularyTree& tree, const StageContext& context) {
  if (context.HasInput("masked_frames") != context.HasInput("masks")) {
    throw UsageError("give both --in masked_frames=PATH and --in masks=PATH, or neither");
  }
  const auto frames = ReadFrames(context.Inputs("frames"));
  const auto cameras = ReadCameras(context.Input("cameras"), frames);
  SiteFeatures features(context.Inputs("features"), context.Inputs("frames"), kMaxFeatures_bytes);
  CheckFeaturesOfFrames(frames, features.Heads());
  if (context.HasInput("masked_frames")) {
    features = KeepFeatures(features,
                            UnmaskedFeatures(ReadFrames(context.Input("masked_frames")),
                                             cameras,
                                             FrameReader({}, context.Inputs("masks")),
                                             features));
  }
  return {frames,
          cameras,
          features,
          &tree,
          ReadPoses(context.Input("trajectory")),
          ReadPoses(context.Input("keyframes"))};
}

}  // namespace nightmap
