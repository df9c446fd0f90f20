// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/map_frame/surface_patches.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "pipeline/base/parallel.h"
#include "pipeline/io/frame_failure.h"

namespace nightmap {

namespace {

constexpr double kFloorMaxDepth_m = 4.0;  // farther depth is ignored

}  // namespace

std::vector<SurfacePatch> SamplePatches(const DepthImage& depth,
                                        const RgbdCamera& camera,
                                        const Rigid3& given_from_camera,
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
      patches.push_back({given_from_camera * center,
                         given_from_camera.rotation * normal,
                         kStep_px * kStep_px * pixel_area_m2 / cosine,
                         -1});
    }
  }
  return patches;
}

std::vector<SurfacePatch> SampleKeyframes(const MapFrameOptions& options,
                                          const MapFrameInput& input,
                                          const std::vector<Keyframe>& keyframes,
                                          int num_threads) {
  const int step = static_cast<int>(input.keyframes.size()) / options.floor_num_keyframes + 1;
  std::vector<std::vector<SurfacePatch>> of_keyframe(keyframes.size());
  ParallelFor(keyframes.size(), num_threads, [&](std::size_t k) {
    const Keyframe& keyframe = keyframes[k];
    if (keyframe.keyframe_idx % step != 0) return;
    // Ignores a failure: the features stage has counted it, and other frames see the floor.
    std::ignore = FrameFailure(keyframe.frame.depth.path, [&] {
      const auto camera_idx = static_cast<std::size_t>(keyframe.frame.camera_idx);
      of_keyframe[k] = SamplePatches(input.load_depth(keyframe.frame),
                                     input.cameras[camera_idx],
                                     keyframe.map_from_camera,
                                     kFloorMaxDepth_m);
    });
    for (SurfacePatch& patch : of_keyframe[k]) patch.camera_idx = keyframe.keyframe_idx;
  });
  std::vector<SurfacePatch> patches;
  for (const auto& part : of_keyframe) patches.insert(patches.end(), part.begin(), part.end());
  return patches;
}

}  // namespace nightmap
