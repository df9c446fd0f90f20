// SPDX-License-Identifier: Apache-2.0
#include "stages/import_trajectory/import_trajectory.h"

#include "pipeline/base/error.h"
#include "pipeline/recording/frame_lists.h"

namespace nightmap {
namespace {

bool IsFar(const ImportTrajectoryOptions& options, const Rigid3& a, const Rigid3& b) {
  return (a.translation - b.translation).norm() >= options.keyframe_distance_m ||
         a.rotation.angularDistance(b.rotation) >= options.keyframe_turn_rad;
}

}  // namespace

void ImportTrajectoryOptions::Register(OptionList& list) {
  list.Add("keyframe_distance_m",
           &keyframe_distance_m,
           Range(0, 10),
           "distance from the last keyframe at which a frame becomes one");
  list.Add("keyframe_turn_rad",
           &keyframe_turn_rad,
           Range(0, 3.2),
           "rotation from the last keyframe at which a frame becomes one");
  list.Add("min_posed_ratio",
           &min_posed_ratio,
           Range(0, 1),
           "share of the frames that must have a pose within 0.1 s");
}

ImportedTrajectory RunImportTrajectory(const ImportTrajectoryOptions& options,
                                       const std::vector<FrameRecord>& frames,
                                       const std::vector<StampedPose>& given) {
  ImportedTrajectory result;
  for (const FrameRecord& frame : frames) {
    const auto pose = TruthAt(given, frame.time_ns);
    if (!pose) continue;
    result.poses.push_back({frame.time_ns, *pose});
    if (result.keyframes.empty() || IsFar(options, *pose, result.keyframes.back().pose)) {
      result.keyframes.push_back(result.poses.back());
    }
  }
  const double min_posed = options.min_posed_ratio * static_cast<double>(frames.size());
  if (result.poses.empty() || static_cast<double>(result.poses.size()) < min_posed) {
    throw ThresholdError(
        "{} of {} frames have a pose within 0.1 s in the given trajectory, fewer than "
        "min_posed_ratio = {}: are its times those of the recording?",
        result.poses.size(),
        frames.size(),
        options.min_posed_ratio);
  }
  return result;
}

}  // namespace nightmap
