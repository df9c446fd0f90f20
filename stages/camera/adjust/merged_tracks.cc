// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/adjust/merged_tracks.h"

#include <algorithm>
#include <limits>

#include "pipeline/base/union_find.h"
#include "stages/camera/adjust/check_tracks.h"

namespace nightmap {
namespace {

// Tracks over all shards, joined by shared features and by loops.
class TrackMerger {
 public:
  explicit TrackMerger(std::size_t num_frames) : track_of_(num_frames) {}

  void Add(const OdometryShard& shard) {
    for (const Track& track : shard.tracks) {
      const auto track_idx = static_cast<std::uint32_t>(sets_.Add());
      for (const Sighting& sighting : track) {
        std::uint32_t& known = At(sighting);
        if (known == kNone) {
          known = track_idx;
        } else {
          sets_.Join(known, track_idx);
        }
      }
    }
  }

  void Join(const FramePair& loop) {
    for (const FeatureMatch& match : loop.inliers) {
      const std::uint32_t a = At({loop.frame_a, match.a});
      const std::uint32_t b = At({loop.frame_b, match.b});
      if (a != kNone && b != kNone) sets_.Join(a, b);
    }
  }

  // Keeps sightings in keyframes only; one per keyframe, that of the lowest feature.
  std::vector<Track> KeyframeTracks(const std::set<int>& keyframes) {
    std::vector<Track> tracks(sets_.Size());
    for (const int frame_idx : keyframes) {
      const auto& track_of = track_of_[static_cast<std::size_t>(frame_idx)];
      for (std::size_t i = 0; i < track_of.size(); ++i) {
        if (track_of[i] == kNone) continue;
        Track& track = tracks[sets_.Find(track_of[i])];
        if (!track.empty() && track.back().frame_idx == frame_idx) continue;
        track.push_back({frame_idx, static_cast<int>(i)});
      }
    }
    std::erase_if(tracks, [](const Track& track) { return track.size() < 2; });
    return tracks;
  }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

  std::uint32_t& At(const Sighting& s) {
    auto& of_frame = track_of_[static_cast<std::size_t>(s.frame_idx)];
    const auto i = static_cast<std::size_t>(s.feature_idx);
    if (of_frame.size() <= i) of_frame.resize(i + 1, kNone);
    return of_frame[i];
  }

  UnionFind sets_;
  std::vector<std::vector<std::uint32_t>> track_of_;  // by frame and feature
};

}  // namespace

std::vector<Track> MergeTracks(const AdjustInput& input, const std::set<int>& keyframes) {
  TrackMerger merger(input.frames.size());
  for (std::size_t i = 0; i < input.num_shards; ++i) {
    const OdometryShard shard = input.odometry(i);
    CheckTracks(i, shard, input.features);
    merger.Add(shard);
  }
  for (std::size_t i = 0; i < input.loops.size(); ++i) {
    if (input.graph.is_loop_accepted[i]) merger.Join(input.loops[i]);
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
