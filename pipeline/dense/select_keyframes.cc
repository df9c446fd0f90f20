// SPDX-License-Identifier: Apache-2.0
// The functions of rgbd_keyframes.h that need no pixels, so that programs without pixels start
// faster: they do not load the decoding libraries.
#include <unordered_map>

#include "pipeline/base/error.h"
#include "pipeline/base/input_error.h"
#include "pipeline/dense/rgbd_keyframes.h"
#include "pipeline/io/trajectory_io.h"

namespace nightmap {

std::vector<Keyframe> SelectKeyframes(const std::vector<FrameRecord>& frames,
                                      const std::vector<RgbdCamera>& cameras,
                                      const std::vector<StampedPose>& keyframe_poses,
                                      int stride) {
  std::unordered_map<std::int64_t, const FrameRecord*> frame_at;
  for (const FrameRecord& frame : frames) frame_at[frame.time_ns] = &frame;
  std::vector<Keyframe> keyframes;
  for (std::size_t i = 0; i < keyframe_poses.size(); i += static_cast<std::size_t>(stride)) {
    const auto found = frame_at.find(keyframe_poses[i].time_ns);
    if (found == frame_at.end()) {
      throw InputError({{"keyframes"}, {"frames"}},
                       "the keyframe at time {} is no frame; a file is damaged or another site's",
                       TimeToString(keyframe_poses[i].time_ns));
    }
    const FrameRecord& frame = *found->second;
    CheckCamera(frame, cameras, "the list of cameras");
    if (frame.depth.path.empty()) continue;
    keyframes.push_back({static_cast<int>(i), frame, keyframe_poses[i].pose});
  }
  return keyframes;
}

void CheckReach(const std::vector<Keyframe>& keyframes, double max_range_m, double reach_m) {
  for (const Keyframe& keyframe : keyframes) {
    const double extent_m =
        keyframe.map_from_camera.translation.cwiseAbs().maxCoeff() + max_range_m;
    if (!(extent_m < reach_m)) {
      throw DataError(
          "keyframe at time {}: its view reaches {} m from the origin, voxels {} m; "
          "correct the trajectory or take larger voxels",
          TimeToString(keyframe.frame.time_ns),
          extent_m,
          reach_m);
    }
  }
}

}  // namespace nightmap
