// SPDX-License-Identifier: Apache-2.0
#include "stages/pose_graph/surface_patches.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "pipeline/base/parallel.h"
#include "pipeline/io/frame_failure.h"
#include "stages/pose_graph/pose_graph.h"

namespace nightmap {

std::vector<SurfacePatch> SamplePatches(const DepthImage& depth,
                                        const RgbdCamera& camera,
                                        const Rigid3& graph_from_camera,
                                        double max_depth_m) {
  constexpr int kStep_px = 12;
  constexpr int kReach_px = 6;
  std::vector<SurfacePatch> patches;
  const auto point_at = [&](int x, int y) {
    return camera.color.BackProject(Eigen::Vector2d(x, y), depth.At(x, y));
  };
  for (int y = kReach_px; y + kReach_px < depth.height; y += kStep_px) {
    for (int x = kReach_px; x + kReach_px < depth.width; x += kStep_px) {
      const float z = depth.At(x, y);
      const float corners[] = {depth.At(x - kReach_px, y),
                               depth.At(x + kReach_px, y),
                               depth.At(x, y - kReach_px),
                               depth.At(x, y + kReach_px)};
      const bool is_smooth = std::ranges::all_of(
          corners, [z](float c) { return c > 0 && std::abs(c - z) < 0.1f * z; });
      if (z <= 0 || z > max_depth_m || !is_smooth) continue;
      const Eigen::Vector3d center = point_at(x, y);
      Eigen::Vector3d normal = (point_at(x + kReach_px, y) - point_at(x - kReach_px, y))
                                   .cross(point_at(x, y + kReach_px) - point_at(x, y - kReach_px));
      if (normal.norm() < 1e-9) continue;
      normal.normalize();
      if (normal.dot(center) > 0) normal = -normal;
      const double cosine = -normal.dot(center.normalized());
      if (cosine < 0.1) continue;
      const double pixel_area_m2 = z * z / (camera.color.fx * camera.color.fy);
      patches.push_back({graph_from_camera * center,
                         graph_from_camera.rotation * normal,
                         kStep_px * kStep_px * pixel_area_m2 / cosine,
                         -1});
    }
  }
  return patches;
}

std::vector<SurfacePatch> SampleKeyframes(const PoseGraphInput& input,
                                          const std::map<int, Rigid3>& graph_from_keyframe,
                                          int max_num_keyframes,
                                          double max_depth_m,
                                          int num_threads) {
  struct Keyframe {
    int frame_idx;
    int camera_idx;
  };
  std::vector<Keyframe> chosen;
  const std::size_t step =
      graph_from_keyframe.size() / static_cast<std::size_t>(max_num_keyframes) + 1;
  std::size_t i = 0;
  for (const auto& [idx, pose] : graph_from_keyframe) {
    if (i % step == 0) chosen.push_back({idx, static_cast<int>(i)});
    ++i;
  }
  std::vector<std::vector<SurfacePatch>> of_keyframe(chosen.size());
  ParallelFor(chosen.size(), num_threads, [&](std::size_t k) {
    const int frame_idx = chosen[k].frame_idx;
    const FrameRecord& frame = input.frames[static_cast<std::size_t>(frame_idx)];
    // The features stage has counted a frame that fails; the floor is seen by others.
    std::ignore = FrameFailure(frame.depth.path, [&] {
      of_keyframe[k] = SamplePatches(input.load_depth(frame),
                                     input.cameras.at(static_cast<std::size_t>(frame.camera_idx)),
                                     graph_from_keyframe.at(frame_idx),
                                     max_depth_m);
      for (SurfacePatch& patch : of_keyframe[k]) patch.camera_idx = chosen[k].camera_idx;
    });
  });
  std::vector<SurfacePatch> patches;
  for (const auto& part : of_keyframe) patches.insert(patches.end(), part.begin(), part.end());
  return patches;
}

}  // namespace nightmap
