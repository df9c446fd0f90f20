// SPDX-License-Identifier: Apache-2.0
// A wall of posters at many depths, rendered and described as a landmark map: for what only whole
// pictures can show.
#pragma once

#include <cmath>
#include <vector>

#include "pipeline/camera/descriptor_distance.h"
#include "pipeline/camera/extract_features.h"
#include "pipeline/world/paint.h"
#include "pipeline/world/render.h"
#include "pipeline/world/route.h"
#include "tests/stages/camera/localize/scene_map.h"

namespace nightmap {

struct RenderedMap {
  SyntheticWorld world;
  RgbdCamera camera;
  ExtractionOptions extraction;
  VocabularyIndex vocabulary;
  LandmarkMap map;

  ColorImage Picture(const Camera& of, const Rigid3& map_from_camera, std::uint64_t seed) const {
    return Render(world, of, map_from_camera, {}, 2.0, seed).color;
  }
};

inline SyntheticWorld PosterWorld() {
  Scene scene;
  for (int i = 0; i < 18; ++i) {
    scene.textures.emplace_back(
        PaintTexture(Paint::kPoster, 256, static_cast<std::uint64_t>(i + 1)));
    const double y = 3.0 - (i % 6), z = 1.0 * (i / 6);
    Surface poster;
    poster.origin = {2.5 + 0.35 * (i * 7 % 5), y, z + 1.0};
    poster.edge_u = {0, -1, 0};
    poster.edge_v = {0.3 * (i % 3 - 1), 0, -1};
    poster.label = SurfaceLabel::kPoster;
    poster.material.texture_idx = i;
    poster.material.period_m = 0;
    scene.surfaces.push_back(poster);
  }
  scene.lamps.push_back({{0, 0, 4}, {0.3, 0.3}, 2.0F});
  return WorldOfScene(std::move(scene));
}

// Poses of the map's cameras: `step` 0 to 5; queries may be between them.
inline Rigid3 PosterPose(double step) {
  return CameraPose({{0, 1.0 - 0.4 * step}, 0.1 * (step - 2.5)}, 1.4, 0.05);
}

// The landmark that shows the same point, or -1.
inline int FindLandmark(const LandmarkMap& map,
                        const Eigen::Vector3d& point_in_map,
                        const std::uint8_t* descriptor) {
  for (int i = 0; i < map.NumLandmarks(); ++i) {
    const auto landmark = static_cast<std::size_t>(i);
    if ((map.positions_in_map[landmark] - point_in_map).norm() > 0.02) continue;
    const int distance = SquaredDistance(map.Descriptor(i), descriptor, 128);
    if (distance < 200 * 200) return i;
  }
  return -1;
}

inline void AddView(const RenderedFrame& frame,
                    const FrameFeatures& features,
                    const MapKeyframe& keyframe,
                    const RenderedMap& rendered,
                    LandmarkMap* map) {
  const int keyframe_idx = static_cast<int>(map->keyframes.size());
  map->keyframes.push_back(keyframe);
  for (std::size_t i = 0; i < features.keypoints_px.size(); ++i) {
    const Eigen::Vector2d pixel = features.keypoints_px[i].cast<double>();
    const double depth_m = frame.exact_depth.At(static_cast<int>(std::lround(pixel.x())),
                                                static_cast<int>(std::lround(pixel.y())));
    if (depth_m <= 0) continue;
    const Eigen::Vector3d point =
        keyframe.map_from_camera * rendered.camera.color.BackProject(pixel, depth_m);
    const std::uint8_t* descriptor = &features.descriptors[128 * i];
    int landmark = FindLandmark(*map, point, descriptor);
    if (landmark < 0) {
      landmark = map->NumLandmarks();
      map->positions_in_map.push_back(point);
      map->position_sigmas_m.push_back(0.01F);
      map->descriptor_landmarks.push_back(landmark);
      map->descriptors.insert(map->descriptors.end(), descriptor, descriptor + 128);
      map->landmark_keyframes.emplace_back();
    }
    auto& keyframes = map->landmark_keyframes[static_cast<std::size_t>(landmark)];
    if (keyframes.empty() || keyframes.back() != keyframe_idx) keyframes.push_back(keyframe_idx);
  }
}

inline RenderedMap MakeRenderedMap() {
  RenderedMap result;
  result.world = PosterWorld();
  result.camera.color = Camera{320, 240, 262.5, 262.5, 159.5, 119.5};
  result.extraction.num_features = 600;
  LandmarkMap& map = result.map;
  std::vector<FrameFeatures> frames;
  for (int i = 0; i < 6; ++i) {
    const Rigid3 pose = PosterPose(i);
    const auto seed = static_cast<std::uint64_t>(i);
    const RenderedFrame frame = Render(result.world, result.camera.color, pose, {}, 2.0, seed);
    const auto features = ExtractFeatures(frame.color, result.camera.color, result.extraction);
    AddView(frame, features, {i, 1000000000LL * (i + 1), pose}, result, &map);
    frames.push_back(features);
  }
  result.vocabulary = IndexOf(VocabularyOf(map.descriptors, frames));
  FillWords(result.vocabulary.tree, &map);
  return result;
}

}  // namespace nightmap
