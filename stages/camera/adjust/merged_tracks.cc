// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/adjust/merged_tracks.h"

#include <algorithm>
#include <map>
#include <unordered_map>

#include "pipeline/base/union_find.h"

namespace nightmap {
namespace {

std::uint64_t Key(const Sighting& s) {
  return (static_cast<std::uint64_t>(s.frame_idx) << 32) |
         static_cast<std::uint32_t>(s.feature_idx);
}

// Tracks over all shards, joined by shared features and by loops.
class TrackMerger {
 public:
  explicit TrackMerger(const std::vector<OdometryShard>& shards) : sets_(CountTracks(shards)) {
    std::size_t track_idx = 0;
    for (const OdometryShard& shard : shards) {
      for (const Track& track : shard.tracks) {
        for (const Sighting& sighting : track) {
          const auto [found, is_new] = track_of_.emplace(Key(sighting), track_idx);
          if (is_new) sightings_.push_back(sighting);
          if (!is_new) sets_.Join(found->second, track_idx);
        }
        ++track_idx;
      }
    }
  }

  void Join(const FramePair& loop) {
    for (const FeatureMatch& match : loop.inliers) {
      const auto a = track_of_.find(Key({loop.frame_a, match.a}));
      const auto b = track_of_.find(Key({loop.frame_b, match.b}));
      if (a != track_of_.end() && b != track_of_.end()) sets_.Join(a->second, b->second);
    }
  }

  // Keeps sightings in keyframes only; one per keyframe.
  std::vector<Track> KeyframeTracks(const std::set<int>& keyframes) {
    std::map<std::size_t, Track> tracks;
    for (const Sighting& sighting : sightings_) {
      if (!keyframes.contains(sighting.frame_idx)) continue;
      tracks[sets_.Find(track_of_.at(Key(sighting)))].push_back(sighting);
    }
    std::vector<Track> result;
    for (auto& [root, track] : tracks) {
      std::ranges::sort(track);
      const auto same_frame = [](const Sighting& a, const Sighting& b) {
        return a.frame_idx == b.frame_idx;
      };
      track.erase(std::unique(track.begin(), track.end(), same_frame), track.end());
      if (track.size() >= 2) result.push_back(std::move(track));
    }
    return result;
  }

 private:
  static std::size_t CountTracks(const std::vector<OdometryShard>& shards) {
    std::size_t count = 0;
    for (const OdometryShard& shard : shards) count += shard.tracks.size();
    return count;
  }

  UnionFind sets_;
  std::unordered_map<std::uint64_t, std::size_t> track_of_;
  std::vector<Sighting> sightings_;
};

}  // namespace

std::vector<Track> MergeTracks(const std::vector<OdometryShard>& shards,
                               const std::vector<FramePair>& loops,
                               const std::vector<bool>& is_accepted,
                               const std::set<int>& keyframes) {
  TrackMerger merger(shards);
  for (std::size_t i = 0; i < loops.size(); ++i) {
    if (is_accepted[i]) merger.Join(loops[i]);
  }
  return merger.KeyframeTracks(keyframes);
}

std::vector<Track> WithoutFrames(std::vector<Track> tracks, const std::set<int>& dropped) {
  for (Track& track : tracks) {
    std::erase_if(track, [&](const Sighting& s) { return dropped.contains(s.frame_idx); });
  }
  std::erase_if(tracks, [](const Track& track) { return track.size() < 2; });
  return tracks;
}

}  // namespace nightmap
