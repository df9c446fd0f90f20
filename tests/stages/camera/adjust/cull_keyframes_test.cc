// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/adjust/cull_keyframes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "stages/camera/adjust/merged_tracks.h"

namespace nightmap::cull_keyframes_test {

// Keyframes 0, 10, 20, .. along a path on which each sees the 400 points about it, 100 of them new;
// every lap sees the same points.
struct Laps {
  std::set<int> keyframes;
  std::vector<Track> tracks;
};

Laps MakeLaps(int num_laps) {
  constexpr int kPlaces = 12;
  Laps laps;
  std::map<int, Track> tracks;
  for (int k = 0; k < num_laps * kPlaces; ++k) {
    laps.keyframes.insert(10 * k);
    for (int i = 0; i < 400; ++i) {
      tracks[(100 * (k % kPlaces) + i) % (100 * kPlaces)].push_back({10 * k, i});
    }
  }
  for (auto& [point, track] : tracks) laps.tracks.push_back(track);
  return laps;
}

TEST(CullKeyframes, EveryPointOfADroppedOneIsSeenByThreeOthers) {
  const Laps laps = MakeLaps(3);
  const std::set<int> dropped = RedundantKeyframes(laps.tracks, laps.keyframes, {}, 0.9);
  EXPECT_GT(dropped.size(), laps.keyframes.size() / 3);
  EXPECT_FALSE(dropped.contains(0));
  EXPECT_FALSE(dropped.contains(*laps.keyframes.rbegin()));
  for (const int keyframe : dropped) {
    int num_seen = 0;
    int num_seen_by_three = 0;
    for (const Track& track : laps.tracks) {
      const auto sees = [&](const Sighting& s) { return s.frame_idx == keyframe; };
      if (std::ranges::none_of(track, sees)) continue;
      const auto num_kept = std::ranges::count_if(
          track, [&](const Sighting& s) { return !dropped.contains(s.frame_idx); });
      ++num_seen;
      num_seen_by_three += num_kept >= 3;
    }
    EXPECT_GT(num_seen_by_three, 0.9 * num_seen) << keyframe;
  }
}

TEST(CullKeyframes, WhatIsSeenOnceStays) {
  const Laps laps = MakeLaps(1);
  // A point is seen by four keyframes in a row; without any of them only by three.
  const auto dropped = RedundantKeyframes(laps.tracks, laps.keyframes, {}, 0.9);
  EXPECT_LE(dropped.size(), laps.keyframes.size() / 4);
  EXPECT_TRUE(RedundantKeyframes(MakeLaps(3).tracks, MakeLaps(3).keyframes, {}, 1).empty());
}

TEST(CullKeyframes, NeededOnesStay) {
  const Laps laps = MakeLaps(3);
  const auto dropped = RedundantKeyframes(laps.tracks, laps.keyframes, {}, 0.9);
  const auto others = RedundantKeyframes(laps.tracks, laps.keyframes, dropped, 0.9);
  for (const int keyframe : others) EXPECT_FALSE(dropped.contains(keyframe));
}

// Consecutive keyframes that stay see at least 30 points in common.
TEST(CullKeyframes, NeighboursStillShareWhatMeasuresTheirMotion) {
  const Laps laps = MakeLaps(8);
  const auto dropped = RedundantKeyframes(laps.tracks, laps.keyframes, {}, 0.5);
  int before = -1;
  for (const int keyframe : laps.keyframes) {
    if (dropped.contains(keyframe)) continue;
    const auto num_shared = std::ranges::count_if(laps.tracks, [&](const Track& track) {
      const auto has = [&](int k) {
        return std::ranges::any_of(track, [k](const Sighting& s) { return s.frame_idx == k; });
      };
      return has(before) && has(keyframe);
    });
    EXPECT_TRUE(before < 0 || num_shared >= 30) << before << " " << keyframe;
    before = keyframe;
  }
}

TEST(CullKeyframes, DroppedFramesLeaveTheTracks) {
  const std::vector<Track> all = {{{0, 1}, {10, 2}, {20, 3}}, {{10, 5}, {20, 6}}};
  EXPECT_EQ(WithoutFrames(all, {10}), TrackList(std::vector<Track>{{{0, 1}, {20, 3}}}));
}

}  // namespace nightmap::cull_keyframes_test
