// SPDX-License-Identifier: Apache-2.0
// An empty box room whose depth images are computed in closed form, for the stages that fuse depth.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "pipeline/dense/rgbd_keyframes.h"

namespace nightmap {

struct BoxRoom {
  Eigen::Vector3d min_m{-2.03, -2.53, -1.27};
  Eigen::Vector3d max_m{2.03, 2.53, 1.27};
  double noise_scale = 1;  // times the camera's depth noise
  bool with_depth = true;
  std::set<int> unreadable;  // frame_idx

  // Depth along z of what a camera inside sees through a ray at z = 1.
  double Depth_m(const Rigid3& map_from_camera, const Eigen::Vector3d& ray) const {
    const Eigen::Vector3d direction = map_from_camera.rotation * ray;
    double depth_m = std::numeric_limits<double>::max();
    for (int axis = 0; axis < 3; ++axis) {
      const double wall = direction[axis] > 0 ? max_m[axis] : min_m[axis];
      if (direction[axis] == 0) continue;
      depth_m = std::min(depth_m, (wall - map_from_camera.translation[axis]) / direction[axis]);
    }
    return depth_m;
  }

  double DistanceToWall_m(const Eigen::Vector3d& point) const {
    return std::min((point - min_m).cwiseAbs().minCoeff(), (max_m - point).cwiseAbs().minCoeff());
  }

  RgbdImages Render(const Keyframe& keyframe, const RgbdCamera& camera) const {
    const int frame_idx = keyframe.frame.frame_idx;
    if (unreadable.count(frame_idx) > 0) throw DataError("frame {}: truncated", frame_idx);
    RgbdImages images;
    const auto num_pixels = static_cast<std::size_t>(camera.color.width * camera.color.height);
    images.color = {camera.color.width, camera.color.height, 3, {}};
    images.color.pixels.assign(num_pixels * 3, 90);
    images.depth = {camera.color.width, camera.color.height, 1, {}};
    Random random(5, static_cast<std::uint64_t>(frame_idx));
    for (int y = 0; y < camera.color.height; ++y) {
      for (int x = 0; x < camera.color.width; ++x) {
        const Eigen::Vector3d ray = camera.color.BackProject(Eigen::Vector2d(x, y), 1.0);
        const double true_m = Depth_m(keyframe.map_from_camera, ray);
        const double error_m = noise_scale * camera.noise.Sigma_m(true_m) * random.Gaussian();
        images.depth.pixels.push_back(with_depth ? static_cast<float>(true_m + error_m) : 0.0F);
      }
    }
    return images;
  }
};

// `num_keyframes` views from the middle of the room, turning around the vertical axis.
inline KeyframeSource LookAround(const BoxRoom& room, int num_keyframes) {
  RgbdCamera camera;
  camera.color = {160, 120, 130, 130, 79.5, 59.5, 0.1, -0.05, 0.001, -0.001, 0};
  KeyframeSource source;
  source.cameras = {camera};
  const Eigen::Quaterniond map_from_level(
      (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished());
  for (int i = 0; i < num_keyframes; ++i) {
    Keyframe keyframe;
    keyframe.keyframe_idx = i;
    keyframe.frame.frame_idx = i;
    keyframe.frame.time_ns = i * 1000;
    keyframe.map_from_camera.rotation =
        Eigen::AngleAxisd(2 * M_PI * i / num_keyframes, Eigen::Vector3d::UnitZ()) * map_from_level;
    keyframe.map_from_camera.translation = {0.05 * (i % 3), 0.07 * (i % 2), 0.03 * (i % 5)};
    source.keyframes.push_back(keyframe);
  }
  source.load = [room, camera](const Keyframe& keyframe) { return room.Render(keyframe, camera); };
  source.load_depth = [room, camera](const Keyframe& keyframe) {
    return room.Render(keyframe, camera).depth;
  };
  return source;
}

}  // namespace nightmap
