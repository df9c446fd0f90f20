// SPDX-License-Identifier: Apache-2.0
#include "pipeline/ceiling/join_tracks.h"

#include "pipeline/base/input_error.h"
#include "tests/test_data.h"

namespace nightmap::join_tracks_test {

CornerSighting At(std::int64_t track_id, float x) { return {track_id, {x, 10}, {x, 10}}; }

TrackedFrame Frame(int idx, std::vector<CornerSighting> sightings) {
  TrackedFrame frame;
  frame.frame_idx = idx;
  frame.time_ns = 1000 + idx;
  frame.sightings = std::move(sightings);
  return frame;
}

TEST(JoinTracks, TracksMeetAtTheFrameThatTwoShardsShare) {
  CornerTracks first, second;
  first.frames = {Frame(0, {At(1, 50), At(2, 80)}), Frame(1, {At(1, 60), At(2, 90)})};
  first.descriptors = {{1, {1}}, {2, {2}}};
  // 7 is track 1 met again; 8 is near to 1 too, but farther; 9 is new.
  second.frames = {Frame(1, {At(7, 60.2F), At(8, 60.6F), At(9, 300)}),
                   Frame(2, {At(7, 70), At(8, 71), At(9, 310)})};
  second.descriptors = {{7, {7}}, {8, {8}}, {9, {9}}};
  const CornerTracks joined = JoinTracks({first, second}, 1);
  ASSERT_EQ(joined.frames.size(), 3U);
  const auto ids = [&](std::size_t frame) {
    std::vector<std::int64_t> found;
    for (const CornerSighting& s : joined.frames[frame].sightings) found.push_back(s.track_id);
    return found;
  };
  EXPECT_EQ(ids(1), (std::vector<std::int64_t>{1, 2}));
  EXPECT_EQ(ids(2), (std::vector<std::int64_t>{1, 8, 9}));
  EXPECT_EQ(joined.frames[2].sightings[0].px.x(), 70);
  std::vector<std::int64_t> described;
  for (const TrackDescriptor& d : joined.descriptors) described.push_back(d.track_id);
  EXPECT_EQ(described, (std::vector<std::int64_t>{1, 2, 8, 9}));
  EXPECT_EQ(joined.descriptors[0].orb[0], 1);
}

TEST(JoinTracks, RefusesShardsThatDoNotFollow) {
  CornerTracks first, second;
  first.frames = {Frame(0, {}), Frame(1, {})};
  second.frames = {Frame(2, {}), Frame(3, {})};
  EXPECT_THROW(JoinTracks({first, second}, 1), InputError);
}

}  // namespace nightmap::join_tracks_test
