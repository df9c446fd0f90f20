// SPDX-License-Identifier: Apache-2.0
// The analytic scene as a landmark map.
#pragma once

#include <algorithm>
#include <set>
#include <vector>

#include "pipeline/io/landmarks_io.h"
#include "stages/camera/localize/localize.h"
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

inline void AddRandomDescriptor(Random& random, FrameFeatures* features) {
  const auto descriptor = RandomRootSift(random);
  features->descriptors.insert(features->descriptors.end(), descriptor.begin(), descriptor.end());
}

// The map in regions side by side: the first has the landmarks below bounds_m[0] in x, and so on.
// Keeps no reference.
inline MapInRegions InRegions(const LandmarkMap& map, const std::vector<double>& bounds_m = {}) {
  std::vector<LandmarkMap> regions(bounds_m.size() + 1);
  const std::vector<int> offsets = map.DescriptorOffsets();
  const auto copy = [](const auto& from, int begin, int end, auto* to) {
    to->insert(to->end(), from.begin() + begin, from.begin() + end);
  };
  for (int i = 0; i < map.NumLandmarks(); ++i) {
    const auto landmark = static_cast<std::size_t>(i);
    const double x_m = map.positions_in_map[landmark].x();
    LandmarkMap& of_region = regions[static_cast<std::size_t>(
        std::ranges::upper_bound(bounds_m, x_m) - bounds_m.begin())];
    const int begin = offsets[landmark];
    const int end = offsets[landmark + 1];
    const int size = DescriptorSize(map.kind);
    of_region.descriptor_landmarks.resize(
        of_region.descriptor_landmarks.size() + static_cast<std::size_t>(end - begin),
        of_region.NumLandmarks());
    copy(map.positions_in_map, i, i + 1, &of_region.positions_in_map);
    copy(map.position_sigmas_m, i, i + 1, &of_region.position_sigmas_m);
    copy(map.landmark_keyframes, i, i + 1, &of_region.landmark_keyframes);
    copy(map.descriptors, begin * size, end * size, &of_region.descriptors);
    copy(map.words, begin * map.num_word_levels, end * map.num_word_levels, &of_region.words);
  }
  MapInRegions in_regions;
  in_regions.head.kind = map.kind;
  in_regions.head.extraction = map.extraction;
  in_regions.head.num_word_levels = map.num_word_levels;
  in_regions.head.keyframes = map.keyframes;
  for (const LandmarkMap& region : regions) {
    std::set<int> keyframes;
    for (const auto& list : region.landmark_keyframes) keyframes.insert(list.begin(), list.end());
    in_regions.regions.push_back({{}, region.NumLandmarks(), {keyframes.begin(), keyframes.end()}});
  }
  in_regions.read = [=](std::size_t region) { return regions.at(region); };
  return in_regions;
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
