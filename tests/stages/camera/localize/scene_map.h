// SPDX-License-Identifier: Apache-2.0
// The analytic scene as a landmark map.
#pragma once

#include <vector>

#include "pipeline/io/landmarks_io.h"
#include "tests/landmark_scene.h"

namespace nightmap {

// Gives each descriptor its words at every level of the tree.
inline void FillWords(const VocabularyTree& tree, LandmarkMap* map) {
  map->num_word_levels = tree.Depth();
  map->words.clear();
  for (int i = 0; i < map->NumDescriptors(); ++i) {
    std::vector<int> path = tree.Path(map->Descriptor(i));
    path.resize(static_cast<std::size_t>(tree.Depth()), path.back());
    map->words.insert(map->words.end(), path.begin(), path.end());
  }
}

// The map of the scene as the landmarks stage would make it, without that stage.
inline LandmarkMap MakeSceneMap(const LandmarkScene& scene, const VocabularyTree& tree) {
  LandmarkMap map;
  map.landmark_keyframes.resize(scene.points_in_map.size());
  for (std::size_t i = 0; i < scene.frames.size(); ++i) {
    map.keyframes.push_back({static_cast<int>(i), scene.poses[i].time_ns, scene.poses[i].pose});
    for (const int point : scene.frame_points[i]) {
      map.landmark_keyframes[static_cast<std::size_t>(point)].push_back(static_cast<int>(i));
    }
  }
  map.positions_in_map = scene.points_in_map;
  map.position_sigmas_m.assign(scene.points_in_map.size(), 0.01F);
  for (std::size_t i = 0; i < scene.descriptors.size(); ++i) {
    const auto& descriptor = scene.descriptors[i];
    map.descriptors.insert(map.descriptors.end(), descriptor.begin(), descriptor.end());
    map.descriptor_landmarks.push_back(static_cast<int>(i));
  }
  FillWords(tree, &map);
  return map;
}

// A second copy of the whole map, moved: every place has a twin.
inline void AddTwin(const Rigid3& moved_from_map, LandmarkMap* map) {
  const LandmarkMap first = *map;
  const int num_keyframes = static_cast<int>(first.keyframes.size());
  for (const MapKeyframe& keyframe : first.keyframes) {
    map->keyframes.push_back({keyframe.frame_idx + num_keyframes,
                              keyframe.time_ns + 1'000'000'000'000,
                              moved_from_map * keyframe.map_from_camera});
  }
  for (int i = 0; i < first.NumLandmarks(); ++i) {
    const auto landmark = static_cast<std::size_t>(i);
    map->positions_in_map.push_back(moved_from_map * first.positions_in_map[landmark]);
    map->position_sigmas_m.push_back(first.position_sigmas_m[landmark]);
    auto& keyframes = map->landmark_keyframes.emplace_back();
    for (const int k : first.landmark_keyframes[landmark]) keyframes.push_back(k + num_keyframes);
  }
  for (const int landmark : first.descriptor_landmarks) {
    map->descriptor_landmarks.push_back(landmark + first.NumLandmarks());
  }
  map->descriptors.insert(
      map->descriptors.end(), first.descriptors.begin(), first.descriptors.end());
  map->words.insert(map->words.end(), first.words.begin(), first.words.end());
}

}  // namespace nightmap
