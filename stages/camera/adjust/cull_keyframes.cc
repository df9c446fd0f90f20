// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/adjust/cull_keyframes.h"

#include <algorithm>
#include <iterator>
#include <map>

namespace nightmap {
namespace {

constexpr int kMinOthers = 3;
constexpr int kMinShared = 30;

class Culler {
 public:
  Culler(const TrackList& tracks, const std::set<int>& keyframes) : kept_(keyframes) {
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      num_views_.push_back(static_cast<int>(tracks[i].size()));
      for (const Sighting& sighting : tracks[i]) tracks_of_[sighting.frame_idx].push_back(i);
    }
  }

  bool IsRedundant(int keyframe, double max_seen_ratio) {
    const auto& seen = tracks_of_[keyframe];
    const auto num_seen_by_others = std::ranges::count_if(
        seen, [&](std::size_t track) { return num_views_[track] > kMinOthers; });
    return static_cast<double>(num_seen_by_others) >
               max_seen_ratio * static_cast<double>(seen.size()) &&
           NeighboursShareEnough(keyframe);
  }

  void Drop(int keyframe) {
    kept_.erase(keyframe);
    for (const std::size_t track : tracks_of_[keyframe]) --num_views_[track];
  }

 private:
  bool NeighboursShareEnough(int keyframe) {
    const auto place = kept_.find(keyframe);
    if (place == kept_.begin() || std::next(place) == kept_.end()) return false;
    const auto& before = tracks_of_[*std::prev(place)];
    const auto& after = tracks_of_[*std::next(place)];
    std::vector<std::size_t> shared;
    std::ranges::set_intersection(before, after, std::back_inserter(shared));
    return static_cast<int>(shared.size()) >= kMinShared;
  }

  std::set<int> kept_;
  std::map<int, std::vector<std::size_t>> tracks_of_;  // by keyframe, ascending
  std::vector<int> num_views_;                         // by track, in kept keyframes
};

}  // namespace

std::set<int> RedundantKeyframes(const TrackList& tracks,
                                 const std::set<int>& keyframes,
                                 const std::set<int>& needed,
                                 double max_seen_ratio) {
  Culler culler(tracks, keyframes);
  std::set<int> redundant;
  for (auto keyframe = keyframes.rbegin(); keyframe != keyframes.rend(); ++keyframe) {
    if (needed.contains(*keyframe) || !culler.IsRedundant(*keyframe, max_seen_ratio)) continue;
    culler.Drop(*keyframe);
    redundant.insert(*keyframe);
  }
  return redundant;
}

}  // namespace nightmap
