// SPDX-License-Identifier: Apache-2.0
#include "pipeline/vision/rgbd_keyframes.h"

#include <unordered_map>

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
      throw DataError("keyframe at time {} has no frame; frames and keyframes must be of one run",
                      TimeToString(keyframe_poses[i].time_ns));
    }
    const FrameRecord& frame = *found->second;
    if (frame.camera_idx < 0 || frame.camera_idx >= static_cast<int>(cameras.size())) {
      throw DataError("frame {}: camera_idx {} is not in the list of {} cameras",
                      frame.frame_idx,
                      frame.camera_idx,
                      cameras.size());
    }
    if (!frame.depth_path.empty()) keyframes.push_back({frame, keyframe_poses[i].pose});
  }
  return keyframes;
}

KeyframeSource OpenKeyframes(const std::vector<std::filesystem::path>& frames_paths,
                             const std::filesystem::path& cameras_path,
                             const std::filesystem::path& keyframes_path,
                             const std::filesystem::path& data_root,
                             int stride) {
  KeyframeSource source;
  source.cameras = ReadCameras(cameras_path);
  source.keyframes =
      SelectKeyframes(ReadFrames(frames_paths), source.cameras, ReadTum(keyframes_path), stride);
  source.load = [cameras = source.cameras, data_root](const Keyframe& keyframe) {
    const RgbdCamera& camera = cameras[static_cast<std::size_t>(keyframe.frame.camera_idx)];
    return LoadRgbd(keyframe.frame, camera, data_root);
  };
  return source;
}

void CheckReach(const std::vector<Keyframe>& keyframes, double max_range_m, double reach_m) {
  for (const Keyframe& keyframe : keyframes) {
    const double extent_m =
        keyframe.map_from_camera.translation.cwiseAbs().maxCoeff() + max_range_m;
    if (!(extent_m < reach_m)) {
      throw DataError(
          "keyframe at time {}: what it sees is {} m from the origin, voxels reach {} m; "
          "correct the trajectory or take larger voxels",
          TimeToString(keyframe.frame.time_ns),
          extent_m,
          reach_m);
    }
  }
}

}  // namespace nightmap
