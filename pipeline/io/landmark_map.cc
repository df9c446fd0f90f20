// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/landmark_map.h"

namespace nightmap {
namespace {

template <typename T>
void Append(const std::vector<T>& more, std::vector<T>* all) {
  all->insert(all->end(), more.begin(), more.end());
}

}  // namespace

std::vector<std::vector<int>> LandmarkMap::KeyframeLandmarks() const {
  std::vector<std::vector<int>> lists(keyframes.size());
  for (int i = 0; i < NumLandmarks(); ++i) {
    for (const int keyframe : landmark_keyframes[static_cast<std::size_t>(i)]) {
      lists[static_cast<std::size_t>(keyframe)].push_back(i);
    }
  }
  return lists;
}

std::vector<int> LandmarkMap::DescriptorOffsets() const {
  std::vector<int> offsets(positions_in_map.size() + 1, NumDescriptors());
  for (int i = NumDescriptors() - 1; i >= 0; --i) {
    offsets[static_cast<std::size_t>(descriptor_landmarks[static_cast<std::size_t>(i)])] = i;
  }
  return offsets;
}

void AppendLandmarks(const LandmarkMap& region, LandmarkMap* map) {
  const int first = map->NumLandmarks();
  Append(region.positions_in_map, &map->positions_in_map);
  Append(region.position_sigmas_m, &map->position_sigmas_m);
  Append(region.descriptors, &map->descriptors);
  for (const int landmark : region.descriptor_landmarks) {
    map->descriptor_landmarks.push_back(first + landmark);
  }
  Append(region.words, &map->words);
  Append(region.landmark_keyframes, &map->landmark_keyframes);
  Append(region.landmark_features, &map->landmark_features);
}

}  // namespace nightmap
