// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_tracks/ceiling_tracks.h"

#include <map>
#include <set>

#include "stages/ceiling/ceiling_tracks/ceiling_tracks_report.h"
#include "tests/stages/ceiling/ceiling_tracks/moving_ceiling.h"
#include "tests/test_data.h"

namespace nightmap::ceiling_tracks_test {

CeilingTracksResult Follow(const CeilingTracksInput& input,
                           int num_threads = 2,
                           const CeilingTracksOptions& options = {}) {
  Progress progress("ceiling_tracks", false);
  return RunCeilingTracks(options, input, progress, num_threads);
}

std::set<std::int64_t> IdsOf(const TrackedFrame& frame) {
  std::set<std::int64_t> ids;
  for (const CornerSighting& sighting : frame.sightings) ids.insert(sighting.track_id);
  return ids;
}

std::size_t NumShared(const TrackedFrame& a, const TrackedFrame& b) {
  const auto ids = IdsOf(a);
  return static_cast<std::size_t>(std::ranges::count_if(
      b.sightings, [&](const CornerSighting& s) { return ids.contains(s.track_id); }));
}

class CeilingTracksTest : public testing::Test {
 protected:
  std::vector<GrayImage> Pictures(int first, int count) const {
    std::vector<GrayImage> pictures;
    for (int i = 0; i < count; ++i) pictures.push_back(ceiling_.Picture(first + i));
    return pictures;
  }
  MovingCeiling ceiling_;
};

TEST_F(CeilingTracksTest, StayOnTheirCornersFor30Frames) {
  const auto result = Follow(InputOf(ceiling_, Pictures(0, 31), 0));
  std::map<std::int64_t, Eigen::Vector2d> points;
  std::map<int, std::pair<double, int>> squares_of_age;
  std::map<std::int64_t, int> lengths;
  for (const TrackedFrame& frame : result.tracks.frames) {
    for (const CornerSighting& sighting : frame.sightings) {
      const Eigen::Vector2d pixel = sighting.raw_px.cast<double>();
      const auto [point, is_new] =
          points.try_emplace(sighting.track_id, ceiling_.PointAt(pixel, frame.frame_idx));
      EXPECT_EQ(is_new, FirstFrameOf(sighting.track_id) == frame.frame_idx);
      auto& [sum, count] = squares_of_age[frame.frame_idx - FirstFrameOf(sighting.track_id)];
      sum += (ceiling_.PixelOf(point->second, frame.frame_idx) - pixel).squaredNorm();
      ++count;
      ++lengths[sighting.track_id];
    }
  }
  for (const auto& [age, squares] : squares_of_age) {  // no drift: the oldest are as exact
    EXPECT_LE(std::sqrt(squares.first / squares.second), 0.15) << age;
  }
  EXPECT_GE(std::ranges::count_if(lengths, [](const auto& l) { return l.second == 31; }), 20);
}

TEST_F(CeilingTracksTest, TheMedianDisplacementIsThatOfTheCeiling) {
  ceiling_.turn_rad = 0;
  const auto frames = Follow(InputOf(ceiling_, Pictures(0, 4), 0)).tracks.frames;
  EXPECT_EQ(frames[0].median_displacement_px, Eigen::Vector2f::Zero());
  EXPECT_TRUE(frames[0].is_redetected);
  for (std::size_t i = 1; i < 4; ++i) {
    const Eigen::Vector2d off = frames[i].median_displacement_px.cast<double>() - ceiling_.step_px;
    EXPECT_LE(off.norm(), 0.05);
    EXPECT_FALSE(frames[i].is_redetected);
  }
}

TEST_F(CeilingTracksTest, FastMotionIsFollowed) {
  ceiling_.step_px = {14, 6};
  ceiling_.turn_rad = 0.05;
  const auto frames = Follow(InputOf(ceiling_, Pictures(0, 4), 0)).tracks.frames;
  for (std::size_t i = 1; i < 4; ++i) {
    EXPECT_GE(NumShared(frames[i - 1], frames[i]), frames[i - 1].sightings.size() * 7 / 10);
  }
}

TEST_F(CeilingTracksTest, AChangeOfLightEndsFewTracks) {
  auto pictures = Pictures(0, 3);
  const auto dim = [](GrayImage picture) {
    for (auto& value : picture.pixels) {
      value = static_cast<std::uint8_t>(std::lround(0.7 * value + 20));
    }
    return picture;
  };
  const auto even = Follow(InputOf(ceiling_, pictures, 0)).tracks.frames;
  pictures[1] = dim(pictures[1]);
  const auto changed = Follow(InputOf(ceiling_, pictures, 0)).tracks.frames;
  for (std::size_t i = 1; i < 3; ++i) {
    EXPECT_GE(NumShared(changed[i - 1], changed[i]), NumShared(even[i - 1], even[i]) * 9 / 10);
    EXPECT_GE(NumShared(changed[i - 1], changed[i]), changed[i - 1].sightings.size() * 8 / 10);
  }
}

TEST_F(CeilingTracksTest, BlankPicturesHaveNoTracks) {
  auto pictures = Pictures(0, 4);
  for (auto& value : pictures[2].pixels) value = 128;
  const auto result = Follow(InputOf(ceiling_, pictures, 0));
  EXPECT_TRUE(result.skipped.empty());
  const auto& frames = result.tracks.frames;
  EXPECT_GT(frames[1].sightings.size(), 60U);
  EXPECT_TRUE(frames[2].sightings.empty());
  EXPECT_GT(frames[3].sightings.size(), 60U);
  for (const std::int64_t id : IdsOf(frames[3])) EXPECT_EQ(FirstFrameOf(id), 3);
}

TEST_F(CeilingTracksTest, APictureThatCannotBeReadIsSkippedAndEndsTracks) {
  auto pictures = Pictures(0, 4);
  pictures[1] = {};
  const auto result = Follow(InputOf(ceiling_, pictures, 0));
  EXPECT_EQ(result.skipped, std::vector<std::string>{"1: truncated"});
  const auto& frames = result.tracks.frames;
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_TRUE(frames[1].sightings.empty());
  EXPECT_EQ(NumShared(frames[0], frames[2]), 0U);
  EXPECT_GT(NumShared(frames[2], frames[3]), 50U);
  EXPECT_EQ(CeilingTracksReport(result)["num_ended"]["new_picture"], frames[0].sightings.size());
}

TEST_F(CeilingTracksTest, AnotherSequenceBeginsAnew) {
  auto input = InputOf(ceiling_, Pictures(0, 4), 0);
  input.frames[2].sequence_idx = input.frames[3].sequence_idx = 1;
  const auto frames = Follow(input).tracks.frames;
  EXPECT_EQ(NumShared(frames[1], frames[2]), 0U);
  EXPECT_EQ(frames[2].median_displacement_px, Eigen::Vector2f::Zero());
}

TEST_F(CeilingTracksTest, AShardBeginsWithTheLastFrameOfTheOneBefore) {
  const auto pictures = Pictures(40, 10);
  const auto before =
      Follow(InputOf(ceiling_, {pictures.begin(), pictures.begin() + 5}, 40)).tracks;
  auto input = InputOf(ceiling_, pictures, 40);
  KeepFramesFrom(45, &input);
  const auto after = Follow(input).tracks;
  ASSERT_EQ(after.frames.size(), 6U);
  EXPECT_EQ(after.frames[0].frame_idx, before.frames.back().frame_idx);
  EXPECT_EQ(after.frames[0].time_ns, before.frames.back().time_ns);
  // An id that both files have is the same corner; most corners are found near an old track.
  std::size_t num_near = 0;
  for (const CornerSighting& sighting : after.frames[0].sightings) {
    EXPECT_EQ(FirstFrameOf(sighting.track_id), 44);
    bool is_near = false;
    for (const CornerSighting& other : before.frames.back().sightings) {
      const float off_px = (other.raw_px - sighting.raw_px).norm();
      is_near = is_near || off_px < 0.5F;
      EXPECT_TRUE(other.track_id != sighting.track_id || off_px == 0);
    }
    num_near += is_near;
  }
  EXPECT_GT(num_near, after.frames[0].sightings.size() / 2);
  const TemporaryFolder folder;  // the reader checks ids, gaps and descriptors
  WriteCornerTracks(folder / "a.h5", after, "");
  EXPECT_EQ(ReadCornerTracks(folder / "a.h5").descriptors.size(), after.descriptors.size());
}

TEST_F(CeilingTracksTest, AreTheSameAtAnyNumberOfThreads) {
  const auto input = InputOf(ceiling_, Pictures(0, 20), 0);
  const TemporaryFolder folder;
  for (const int num_threads : {1, 4}) {
    WriteCornerTracks(folder / std::to_string(num_threads), Follow(input, num_threads).tracks, "");
  }
  EXPECT_EQ(ReadBytes(folder / "1"), ReadBytes(folder / "4"));
}

TEST_F(CeilingTracksTest, FeaturesMustHaveOrbDescriptors) {
  auto input = InputOf(ceiling_, Pictures(0, 2), 0);
  input.features.kind = DescriptorKind::kRootSift;
  NIGHTMAP_EXPECT_ERROR(DataError, Follow(input), "set features.detector");
}

}  // namespace nightmap::ceiling_tracks_test
