// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/map_parts.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "pipeline/base/input_error.h"

namespace nightmap {
namespace {

constexpr int kNumAlikeFrames = 200;   // retrieved per picture, keyframes or not
constexpr int kNumAlikeKeyframes = 5;  // whose scores rank a region
// The rarest words choose parts. Words of half the map's frames tell no places apart, only make all
// parts alike, and are most of what a query in a large map reads.
constexpr std::size_t kMinWords = 100;
constexpr std::size_t kMaxPostings = 500'000;

// The keyframe of each frame, or -1, up to the last that is one.
std::vector<int> FrameKeyframes(const std::vector<MapKeyframe>& keyframes) {
  std::vector<int> of_frame;
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    const auto frame = static_cast<std::size_t>(keyframes[i].frame_idx);
    if (frame >= of_frame.size()) of_frame.resize(frame + 1, -1);
    of_frame[frame] = static_cast<int>(i);
  }
  return of_frame;
}

// Drops keyframes that see none of the landmarks; the others keep their order.
void KeepSeeingKeyframes(LandmarkMap* map) {
  std::vector<int> new_idx(map->keyframes.size(), -1);
  for (const auto& list : map->landmark_keyframes) {
    for (const int keyframe : list) new_idx[static_cast<std::size_t>(keyframe)] = 0;
  }
  std::vector<MapKeyframe> kept;
  for (std::size_t i = 0; i < new_idx.size(); ++i) {
    if (new_idx[i] < 0) continue;
    new_idx[i] = static_cast<int>(kept.size());
    kept.push_back(map->keyframes[i]);
  }
  map->keyframes = std::move(kept);
  for (auto& list : map->landmark_keyframes) {
    for (int& keyframe : list) keyframe = new_idx[static_cast<std::size_t>(keyframe)];
  }
}

template <typename T>
std::size_t Bytes(const std::vector<T>& list) {
  return list.size() * sizeof(T);
}

// Memory of a map with its index, about: the index holds the descriptors once more, and lists of
// landmarks; a list of a few numbers takes 32 bytes more.
std::size_t IndexedBytes(const LandmarkMap& map) {
  std::size_t num_observations = 0;
  for (const auto& list : map.landmark_keyframes) num_observations += list.size();
  constexpr std::size_t kTreeBytes = 32;  // of the k-d tree, per landmark
  return 2 * Bytes(map.descriptors) + Bytes(map.words) + 2 * Bytes(map.descriptor_landmarks) +
         Bytes(map.positions_in_map) + Bytes(map.position_sigmas_m) +
         Bytes(map.landmark_keyframes) + 2 * num_observations * sizeof(int) +
         map.positions_in_map.size() * (32 + sizeof(int) + kTreeBytes);
}

}  // namespace

MapInRegions RegionsOf(LandmarksReader& reader) {
  return {reader.Head(), reader.Regions(), [&](std::size_t region) { return reader.Read(region); }};
}

LandmarkMap ReadRegions(const MapInRegions& map,
                        const std::vector<std::size_t>& regions,
                        const VocabularyTree& tree) {
  LandmarkMap read = map.head;
  for (const std::size_t region : regions) {
    LandmarkMap of_region = map.read(region);
    of_region.landmark_features.clear();  // nothing here asks for them
    const auto max_word = std::ranges::max_element(of_region.words);
    if (max_word != of_region.words.end() && *max_word >= tree.NumNodes()) {
      throw InputError({{"landmarks"}, {"vocabulary"}}, "made with another vocabulary");
    }
    AppendLandmarks(std::move(of_region), &read);
  }
  return read;
}

struct MapParts::Loaded {
  Loaded(std::size_t number,
         LandmarkMap map_of_part,
         const LocalizeOptions& options,
         const VocabularyIndex& vocabulary)
      : part(number),
        map(std::move(map_of_part)),
        bytes(IndexedBytes(map)),
        localizer(options, map, vocabulary) {}

  std::size_t part;
  LandmarkMap map;
  std::size_t bytes;
  Localizer localizer;
};

MapParts::MapParts(const LocalizeOptions& options,
                   const MapInRegions& map,
                   const VocabularyIndex& vocabulary,
                   const MapLimits& limits)
    : options_(options),
      map_(map),
      vocabulary_(vocabulary),
      limits_(limits),
      keyframe_regions_(map.head.keyframes.size()),
      frame_keyframes_(FrameKeyframes(map.head.keyframes)) {
  for (std::size_t region = 0; region < map.regions.size(); ++region) {
    for (const int keyframe : map.regions[region].keyframes) {
      keyframe_regions_[static_cast<std::size_t>(keyframe)].push_back(region);
    }
  }
  for (std::size_t part = 0; part < map.regions.size(); ++part) {
    part_regions_.push_back(RegionsOf(part));
  }
}

std::vector<std::size_t> MapParts::RegionsOf(std::size_t part) const {
  std::vector<std::size_t> num_shared(map_.regions.size(), 0);
  for (const int keyframe : map_.regions[part].keyframes) {
    for (const std::size_t region : keyframe_regions_[static_cast<std::size_t>(keyframe)]) {
      ++num_shared[region];
    }
  }
  std::vector<std::size_t> neighbours(map_.regions.size());
  std::iota(neighbours.begin(), neighbours.end(), std::size_t{0});
  std::erase_if(neighbours, [&](std::size_t i) { return i == part || num_shared[i] == 0; });
  std::ranges::stable_sort(
      neighbours, std::greater<>(), [&](std::size_t i) { return num_shared[i]; });
  std::vector<std::size_t> regions{part};
  std::int64_t num_landmarks = map_.regions[part].num_landmarks;
  for (const std::size_t region : neighbours) {
    num_landmarks += map_.regions[region].num_landmarks;
    if (num_landmarks > limits_.part_landmarks) break;
    regions.push_back(region);
  }
  std::ranges::sort(regions);
  return regions;
}

std::vector<AlikePart> MapParts::MostAlike(const FrameFeatures& features) const {
  struct Keyframe {
    const std::vector<std::size_t>& regions;
    double score;
  };
  const auto words = vocabulary_.tree.LeafWords(features.descriptors, 1);
  std::vector<Keyframe> alike;
  for (const auto& [frame_idx, score] :
       vocabulary_.frames.QueryRarest(words, kNumAlikeFrames, kMinWords, kMaxPostings)) {
    const auto frame = static_cast<std::size_t>(frame_idx);
    if (frame >= frame_keyframes_.size() || frame_keyframes_[frame] < 0) continue;
    alike.push_back({keyframe_regions_[static_cast<std::size_t>(frame_keyframes_[frame])], score});
  }
  std::vector<AlikePart> parts;
  while (parts.size() < static_cast<std::size_t>(limits_.parts_per_picture)) {
    std::vector<double> scores(map_.regions.size(), 0.0);
    std::vector<int> num_keyframes(map_.regions.size(), 0);
    for (const auto& [regions, score] : alike) {
      for (const std::size_t region : regions) {
        if (num_keyframes[region]++ < kNumAlikeKeyframes) scores[region] += score;
      }
    }
    for (const AlikePart& found : parts) scores[found.part] = 0;
    const auto best = std::ranges::max_element(scores);
    if (best == scores.end() || *best == 0) break;
    const auto part = static_cast<std::size_t>(best - scores.begin());
    parts.push_back({part, *best});
    const std::vector<std::size_t>& inside = part_regions_[part];
    std::vector<Keyframe> others;
    for (const Keyframe& keyframe : alike) {
      if (!std::ranges::includes(inside, keyframe.regions)) others.push_back(keyframe);
    }
    alike.swap(others);
  }
  return parts;
}

LandmarkMap MapParts::ReadPart(std::size_t part) const {
  LandmarkMap map = ReadRegions(map_, part_regions_[part], vocabulary_.tree);
  KeepSeeingKeyframes(&map);
  return map;
}

bool MapParts::IsLoaded(std::size_t part) const {
  return std::ranges::any_of(loaded_, [&](const auto& loaded) { return loaded->part == part; });
}

const Localizer& MapParts::Load(std::size_t part) {
  const auto found =
      std::ranges::find_if(loaded_, [&](const auto& loaded) { return loaded->part == part; });
  if (found != loaded_.end()) {
    loaded_.splice(loaded_.begin(), loaded_, found);
    return loaded_.front()->localizer;
  }
  LandmarkMap map = ReadPart(part);
  std::size_t bytes = IndexedBytes(map);
  for (const auto& loaded : loaded_) bytes += loaded->bytes;
  while (!loaded_.empty() && bytes > limits_.bytes) {
    bytes -= loaded_.back()->bytes;
    loaded_.pop_back();
  }
  loaded_.push_front(std::make_shared<const Loaded>(part, std::move(map), options_, vocabulary_));
  return loaded_.front()->localizer;
}

}  // namespace nightmap
