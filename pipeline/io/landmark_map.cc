// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/landmark_map.h"

#include <iterator>
#include <utility>

namespace nightmap {
namespace {

template <typename T>
void Append(std::vector<T> more, std::vector<T>* all) {
  if (all->empty()) {
    all->swap(more);
  } else {
    all->insert(all->end(), std::move_iterator(more.begin()), std::move_iterator(more.end()));
  }
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

void AppendLandmarks(LandmarkMap region, LandmarkMap* map) {
  const int first = map->NumLandmarks();
  for (int& landmark : region.descriptor_landmarks) landmark += first;
  Append(std::move(region.positions_in_map), &map->positions_in_map);
  Append(std::move(region.position_sigmas_m), &map->position_sigmas_m);
  Append(std::move(region.descriptors), &map->descriptors);
  Append(std::move(region.descriptor_landmarks), &map->descriptor_landmarks);
  Append(std::move(region.words), &map->words);
  Append(std::move(region.landmark_keyframes), &map->landmark_keyframes);
  Append(std::move(region.landmark_features), &map->landmark_features);
}

}  // namespace nightmap
