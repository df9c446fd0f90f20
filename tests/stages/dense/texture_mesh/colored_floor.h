// SPDX-License-Identifier: Apache-2.0
// A colored floor as a mesh, and pictures of it that are computed in closed form.
#pragma once

#include <cmath>
#include <vector>

#include "pipeline/base/error.h"
#include "pipeline/dense/mesh_io.h"
#include "pipeline/dense/rgbd_keyframes.h"

namespace nightmap {

constexpr int kNumX = 40, kNumY = 16;  // cells of 5 cm
constexpr double kCell_m = 0.05;
constexpr double kOccluder_m = 0.5;  // its height above the floor

// The colors of the floor: waves of 20 cm, so that a texel of 5 mm is up to 15 gray levels.
inline Eigen::Array3d FloorColor(double x_m, double y_m) {
  const double turn = 2 * M_PI / 0.2;
  return {128 + 100 * std::sin(turn * x_m), 128 + 100 * std::sin(turn * y_m), 90};
}

// The floor 0 <= x < 2, 0 <= y < 0.8, seen from above, or from below. It is one component.
inline TileMesh Floor(bool is_seen_from_above = true) {
  TileMesh mesh;
  for (int y = 0; y <= kNumY; ++y) {
    for (int x = 0; x <= kNumX; ++x) {
      const Eigen::Vector2d at = kCell_m * Eigen::Vector2d(x, y);
      const Eigen::Array3d rgb = FloorColor(at.x(), at.y()).round();
      MeshVertex& vertex = mesh.vertices.emplace_back();
      vertex.position_in_map = {static_cast<float>(at.x()), static_cast<float>(at.y()), 0};
      vertex.normal_in_map = {0, 0, is_seen_from_above ? 1.0F : -1.0F};
      for (int c = 0; c < 3; ++c) {
        vertex.rgb[static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(rgb[c]);
      }
    }
  }
  for (int y = 0; y < kNumY; ++y) {
    for (int x = 0; x < kNumX; ++x) {
      const auto a = static_cast<std::uint32_t>(y * (kNumX + 1) + x);
      const std::uint32_t b = a + 1, c = a + kNumX + 1, d = c + 1;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({a, d, c});
    }
  }
  if (!is_seen_from_above) {
    for (Triangle& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  }
  mesh.components = {{static_cast<std::uint32_t>(mesh.vertices.size()),
                      0,
                      static_cast<std::uint32_t>(mesh.triangles.size()),
                      kNumX * kNumY * kCell_m * kCell_m}};
  return mesh;
}

// Cameras 1 m above the floor that look down on it; one of them may be broken.
struct Scene {
  std::vector<double> cameras_x_m;
  double occluded_to_x_m = -10;  // the end of a red plate above the floor
  double brightness = 1;
  int unreadable = -1;  // frame_idx

  RgbdImages Render(const Keyframe& keyframe, const RgbdCamera& camera) const {
    if (keyframe.frame.frame_idx == unreadable) throw DataError("picture 0: truncated");
    RgbdImages images;
    images.color = {camera.color.width, camera.color.height, 3, {}};
    images.depth = {camera.color.width, camera.color.height, 1, {}};
    for (int y = 0; y < camera.color.height; ++y) {
      for (int x = 0; x < camera.color.width; ++x) {
        const Eigen::Vector3d ray =
            keyframe.map_from_camera.rotation * camera.color.BackProject({x, y}, 1);
        const Eigen::Vector3d& from = keyframe.map_from_camera.translation;
        const Eigen::Vector3d on_plate = from + (from.z() - kOccluder_m) * ray;
        const bool is_plate = on_plate.x() < occluded_to_x_m;
        const Eigen::Vector3d on_floor = from + from.z() * ray;
        const Eigen::Array3d rgb =
            is_plate ? Eigen::Array3d(255, 0, 0) : FloorColor(on_floor.x(), on_floor.y());
        for (int c = 0; c < 3; ++c) {
          images.color.pixels.push_back(
              static_cast<std::uint8_t>(std::floor(brightness * rgb[c] + 0.5)));
        }
        images.depth.pixels.push_back(
            static_cast<float>(is_plate ? from.z() - kOccluder_m : from.z()));
      }
    }
    return images;
  }

  KeyframeSource Source() const {
    RgbdCamera camera;
    camera.color = {320, 240, 240, 240, 159.5, 119.5, 0.1, -0.05, 0.001, -0.001, 0};
    KeyframeSource source;
    source.cameras = {camera};
    source.region.max_range_m = 4;
    for (const double x_m : cameras_x_m) {
      Keyframe& keyframe = source.keyframes.emplace_back();
      keyframe.keyframe_idx = static_cast<int>(source.keyframes.size()) * 3;
      keyframe.frame.frame_idx = static_cast<int>(source.keyframes.size()) - 1;
      keyframe.map_from_camera.rotation = {0, 1, 0, 0};
      keyframe.map_from_camera.translation = {x_m, 0.4, 1};
    }
    source.load = [*this, camera](const Keyframe& keyframe) { return Render(keyframe, camera); };
    Scene readable = *this;
    readable.unreadable = -1;
    source.load_depth = [readable, camera](const Keyframe& keyframe) {
      return readable.Render(keyframe, camera).depth;
    };
    return source;
  }
};

}  // namespace nightmap
