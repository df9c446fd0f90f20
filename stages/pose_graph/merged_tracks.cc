// SPDX-License-Identifier: Apache-2.0
#include "stages/pose_graph/merged_tracks.h"

#include <algorithm>
#include <map>
#include <unordered_map>

#include "pipeline/base/union_find.h"

namespace nightmap {
namespace {

std::uint64_t Key(int frame_idx, int feature_idx) {
  return (static_cast<std::uint64_t>(frame_idx) << 32) | static_cast<std::uint32_t>(feature_idx);
}

// Tracks over all shards, joined by shared features and by loops.
class TrackMerger {
 public:
  explicit TrackMerger(const std::vector<OdometryShard>& shards) : sets_(CountTracks(shards)) {
    std::size_t first_track = 0;
    for (const OdometryShard& shard : shards) {
      std::size_t num_tracks = 0;
      for (const TrackObservation& o : shard.observations) {
        const std::size_t track = first_track + static_cast<std::size_t>(o.track_idx);
        num_tracks = std::max(num_tracks, static_cast<std::size_t>(o.track_idx) + 1);
        const auto [found, is_new] = track_of_.emplace(Key(o.frame_idx, o.feature_idx), track);
        if (is_new) sightings_.push_back({o.frame_idx, o.feature_idx});
        if (!is_new) sets_.Join(found->second, track);
      }
      first_track += num_tracks;
    }
  }

  void Join(const FramePair& loop) {
    for (const FeatureMatch& match : loop.inliers) {
      const auto a = track_of_.find(Key(loop.frame_a, match.a));
      const auto b = track_of_.find(Key(loop.frame_b, match.b));
      if (a != track_of_.end() && b != track_of_.end()) sets_.Join(a->second, b->second);
    }
  }

  // Sightings in keyframes only; one per keyframe.
  std::vector<Track> KeyframeTracks(const std::set<int>& keyframes) {
    std::map<std::size_t, Track> tracks;
    for (const Sighting& sighting : sightings_) {
      if (!keyframes.contains(sighting.first)) continue;
      tracks[sets_.Find(track_of_.at(Key(sighting.first, sighting.second)))].push_back(sighting);
    }
    std::vector<Track> result;
    for (auto& [root, track] : tracks) {
      std::ranges::sort(track);
      const auto same_frame = [](const Sighting& a, const Sighting& b) {
        return a.first == b.first;
      };
      track.erase(std::unique(track.begin(), track.end(), same_frame), track.end());
      if (track.size() >= 2) result.push_back(std::move(track));
    }
    return result;
  }

 private:
  static std::size_t CountTracks(const std::vector<OdometryShard>& shards) {
    std::size_t count = 0;
    for (const OdometryShard& shard : shards) {
      int last = -1;
      for (const TrackObservation& o : shard.observations) last = std::max(last, o.track_idx);
      count += static_cast<std::size_t>(last + 1);
    }
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
    std::erase_if(track, [&](const Sighting& s) { return dropped.contains(s.first); });
  }
  std::erase_if(tracks, [](const Track& track) { return track.size() < 2; });
  return tracks;
}

}  // namespace nightmap
