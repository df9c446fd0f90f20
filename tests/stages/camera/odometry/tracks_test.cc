// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/odometry/tracks.h"

#include <gtest/gtest.h>

#include <set>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"

namespace nightmap::tracks_test {

TEST(Tracks, JoinsAcrossFrames) {
  TrackBuilder builder(10, {3, 3, 3});
  builder.Join(10, 1, 11, 2);
  builder.Join(11, 2, 12, 0);
  EXPECT_EQ(builder.Build(), (std::vector<Track>{{{10, 1}, {11, 2}, {12, 0}}}));
}

TEST(Tracks, IgnoresAMatchThatContradicts) {
  TrackBuilder builder(0, {2, 2});
  builder.Join(0, 0, 1, 0);
  builder.Join(0, 1, 1, 0);  // would put two features of frame 0 into one track
  EXPECT_EQ(builder.Build(), (std::vector<Track>{{{0, 0}, {1, 0}}}));
}

TEST(Tracks, NeverHoldTwoFeaturesOfOneFrame) {
  Random random(4);
  TrackBuilder builder(0, {20, 20, 20, 20, 20});
  for (int i = 0; i < 300; ++i) {
    const int a = static_cast<int>(random.Index(5));
    const int b = static_cast<int>(random.Index(5));
    if (a == b) continue;
    builder.Join(a, static_cast<int>(random.Index(20)), b, static_cast<int>(random.Index(20)));
  }
  const std::vector<Track> tracks = builder.Build();
  EXPECT_FALSE(tracks.empty());
  for (const Track& track : tracks) {
    std::set<int> frames;
    for (const Sighting& s : track) EXPECT_TRUE(frames.insert(s.frame_idx).second);
  }
}

TEST(Tracks, RefusesFeaturesThatDoNotExist) {
  TrackBuilder builder(0, {2, 2});
  EXPECT_THROW(builder.Join(0, 2, 1, 0), DataError);
  EXPECT_THROW(builder.Join(0, 0, 2, 0), DataError);
}

}  // namespace nightmap::tracks_test
