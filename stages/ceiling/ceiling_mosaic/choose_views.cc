// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_mosaic/choose_views.h"

namespace nightmap {

namespace {

constexpr double kViewDistance_m = 0.3;  // distance between the pictures that the mosaic is made of
constexpr double kViewTurn_rad = 0.3;    // and turn between them

}  // namespace

std::vector<CeilingView> ChooseViews(const std::vector<FrameRecord>& frames,
                                     const std::vector<StampedPose>& poses,
                                     const Rigid3& robot_from_camera) {
  std::vector<CeilingView> views;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const int pose = FindPose(poses, frames[i].time_ns);
    if (pose < 0) continue;
    const Rigid3 map_from_camera = poses[static_cast<std::size_t>(pose)].pose * robot_from_camera;
    if (!views.empty()) {
      const Rigid3 moved = views.back().map_from_camera.Inverse() * map_from_camera;
      if (moved.translation.norm() < kViewDistance_m &&
          Eigen::AngleAxisd(moved.rotation).angle() < kViewTurn_rad) {
        continue;
      }
    }
    views.push_back({map_from_camera, i});
  }
  return views;
}

}  // namespace nightmap
