// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/adjust/merged_tracks.h"

#include <algorithm>
#include <limits>
#include <utility>

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

  // Forgets what a frame sees.
  void Drop(int frame_idx) { track_of_[static_cast<std::size_t>(frame_idx)] = {}; }

  // Keeps sightings in keyframes only; one per keyframe, that of the lowest feature.
  TrackList KeyframeTracks(const std::set<int>& keyframes) {
    std::vector<std::uint32_t> lengths(sets_.Size(), 0);
    VisitKeyframes(keyframes, [&](std::size_t set, const Sighting&) { ++lengths[set]; });
    TrackList tracks;
    std::vector<std::size_t> next(sets_.Size());
    for (std::size_t set = 0; set < lengths.size(); ++set) {
      if (lengths[set] < 2) continue;
      next[set] = tracks.NumSightings();
      tracks.AddEmpty(lengths[set]);
    }
    VisitKeyframes(keyframes, [&](std::size_t set, const Sighting& s) {
      if (lengths[set] >= 2) tracks.At(next[set]++) = s;
    });
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

  // Calls visit(set, sighting) for the first sighting of each set in each keyframe.
  void VisitKeyframes(const std::set<int>& keyframes, const auto& visit) {
    std::vector<int> last_frame(sets_.Size(), -1);
    for (const int frame_idx : keyframes) {
      const auto& track_of = track_of_[static_cast<std::size_t>(frame_idx)];
      for (std::size_t i = 0; i < track_of.size(); ++i) {
        if (track_of[i] == kNone) continue;
        const std::size_t set = sets_.Find(track_of[i]);
        if (std::exchange(last_frame[set], frame_idx) == frame_idx) continue;
        visit(set, Sighting{frame_idx, static_cast<int>(i)});
      }
    }
  }

  UnionFind sets_;
  std::vector<std::vector<std::uint32_t>> track_of_;  // by frame and feature
};

// Keyframes, and frames that accepted loops join.
std::vector<bool> NeededFrames(const AdjustInput& input,
                               const std::vector<FramePair>& loops,
                               const std::set<int>& keyframes) {
  std::vector<bool> is_needed(input.frames.size(), false);
  for (const int frame_idx : keyframes) is_needed[static_cast<std::size_t>(frame_idx)] = true;
  for (std::size_t i = 0; i < loops.size(); ++i) {
    if (!input.graph.is_loop_accepted[i]) continue;
    is_needed[static_cast<std::size_t>(loops[i].frame_a)] = true;
    is_needed[static_cast<std::size_t>(loops[i].frame_b)] = true;
  }
  return is_needed;
}

}  // namespace

TrackList MergeTracks(const AdjustInput& input,
                      const std::vector<FramePair>& loops,
                      const std::set<int>& keyframes) {
  const std::vector<bool> is_needed = NeededFrames(input, loops, keyframes);
  TrackMerger merger(input.frames.size());
  std::vector<OdometryFrame> frames_before;  // tracks of a shard have frames of the one before it
  const auto drop_needless = [&] {
    for (const OdometryFrame& frame : frames_before) {
      if (!is_needed[static_cast<std::size_t>(frame.frame_idx)]) merger.Drop(frame.frame_idx);
    }
  };
  for (std::size_t i = 0; i < input.num_shards; ++i) {
    OdometryShard shard = input.odometry(i);
    CheckTracks(i, shard, input.features);
    merger.Add(shard);
    drop_needless();
    frames_before = std::move(shard.frames);
  }
  drop_needless();
  for (std::size_t i = 0; i < loops.size(); ++i) {
    if (input.graph.is_loop_accepted[i]) merger.Join(loops[i]);
  }
  return merger.KeyframeTracks(keyframes);
}

TrackList WithoutFrames(const TrackList& tracks, const std::set<int>& dropped) {
  TrackList kept;
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    Track track(tracks[i].begin(), tracks[i].end());
    std::erase_if(track, [&](const Sighting& s) { return dropped.contains(s.frame_idx); });
    if (track.size() >= 2) kept.Add(track);
  }
  return kept;
}

}  // namespace nightmap
