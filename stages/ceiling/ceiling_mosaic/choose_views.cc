// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_mosaic/choose_views.h"

namespace nightmap {

std::vector<CeilingView> ChooseViews(const CeilingMosaicOptions& options,
                                     const std::vector<FrameRecord>& frames,
                                     const std::vector<StampedPose>& poses,
                                     const Rigid3& robot_from_camera) {
  std::vector<CeilingView> views;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const int pose = FindPose(poses, frames[i].time_ns);
    if (pose < 0) continue;
    const Rigid3 map_from_camera = poses[static_cast<std::size_t>(pose)].pose * robot_from_camera;
    if (!views.empty()) {
      const Rigid3 moved = views.back().map_from_camera.Inverse() * map_from_camera;
      if (moved.translation.norm() < options.view_distance_m &&
          Eigen::AngleAxisd(moved.rotation).angle() < options.view_turn_rad) {
        continue;
      }
    }
    views.push_back({map_from_camera, i});
  }
  return views;
}

}  // namespace nightmap
