// SPDX-License-Identifier: Apache-2.0
#include "pipeline/ceiling/corner_tracks_io.h"

#include <functional>
#include <limits>

#include "tests/io/artifact_damage.h"
#include "tests/io/hdf5_damage.h"

namespace nightmap::corner_tracks_io_test {

constexpr char kFormat[] = "nightmap corner tracks";
const auto kRead = [](const std::filesystem::path& path) { return ReadCornerTracks(path); };

// Frames 7 to 10: one track from the first to the third, one in the second alone, one from the
// third on; nothing is left in the last.
CornerTracks SomeTracks() {
  const std::int64_t a = MakeTrackId(7, 3), b = MakeTrackId(8, 0), c = MakeTrackId(9, 1);
  CornerTracks tracks;
  tracks.frames = {{100, 7, {{a, {10, 20}, {11, 21}}}, {0, 0}, true},
                   {300, 8, {{a, {12.5F, 20}, {13.5F, 21}}, {b, {50, 60}, {51, 61}}}, {2.5F, 0}},
                   {200, 9, {{a, {14, 21}, {15, 22}}, {c, {70, 80}, {71, 81}}}, {1.5F, 1}},
                   {400, 10, {}, {0, 0}}};
  for (const std::int64_t id : {a, b, c}) {
    tracks.descriptors.push_back({id, {}});
    tracks.descriptors.back().orb.fill(static_cast<std::uint8_t>(id % 251));
  }
  return tracks;
}

TEST(CornerTracksIo, IdsTellWhereTracksBegin) {
  const std::int64_t id = MakeTrackId(123'456, 1'000'000);
  EXPECT_EQ(FirstFrameOf(id), 123'456);
  EXPECT_EQ(FirstFeatureOf(id), 1'000'000);
  EXPECT_LT(MakeTrackId(4, 1'048'575), MakeTrackId(5, 0));
}

TEST(CornerTracksIo, ReadsBackEveryField) {
  const TemporaryFolder folder;
  const CornerTracks tracks = SomeTracks();
  WriteCornerTracks(folder / "t.h5", tracks, "x = 1\n");
  const CornerTracks read = ReadCornerTracks(folder / "t.h5");
  ASSERT_EQ(read.frames.size(), tracks.frames.size());
  for (std::size_t i = 0; i < tracks.frames.size(); ++i) {
    const TrackedFrame &frame = tracks.frames[i], &again = read.frames[i];
    EXPECT_EQ(again.frame_idx, frame.frame_idx);
    EXPECT_EQ(again.time_ns, frame.time_ns);
    EXPECT_EQ(again.median_displacement_px, frame.median_displacement_px);
    EXPECT_EQ(again.is_redetected, frame.is_redetected);
    ASSERT_EQ(again.sightings.size(), frame.sightings.size());
    for (std::size_t k = 0; k < frame.sightings.size(); ++k) {
      EXPECT_EQ(again.sightings[k].track_id, frame.sightings[k].track_id);
      EXPECT_EQ(again.sightings[k].raw_px, frame.sightings[k].raw_px);
      EXPECT_EQ(again.sightings[k].px, frame.sightings[k].px);
    }
  }
  ASSERT_EQ(read.descriptors.size(), tracks.descriptors.size());
  for (std::size_t i = 0; i < tracks.descriptors.size(); ++i) {
    EXPECT_EQ(read.descriptors[i].track_id, tracks.descriptors[i].track_id);
    EXPECT_EQ(read.descriptors[i].orb, tracks.descriptors[i].orb);
  }
  WriteCornerTracks(folder / "again.h5", read, "x = 1\n");
  EXPECT_EQ(ReadBytes(folder / "again.h5"), ReadBytes(folder / "t.h5"));
}

TEST(CornerTracksIo, NoTracksAndNoFramesAreFine) {
  const TemporaryFolder folder;
  WriteCornerTracks(folder / "t.h5", {}, "");
  EXPECT_TRUE(ReadCornerTracks(folder / "t.h5").frames.empty());
  WriteCornerTracks(folder / "t.h5", {{{100, 3, {}, {0, 0}, false}}, {}}, "");
  EXPECT_EQ(ReadCornerTracks(folder / "t.h5").frames.size(), 1U);
}

TEST(CornerTracksIo, ATruncatedFileIsNamed) {
  const TemporaryFolder folder;
  WriteCornerTracks(folder / "t.h5", SomeTracks(), "");
  ExpectTruncationIsNamed(folder, folder / "t.h5", kRead);
}

TEST(CornerTracksIo, AnotherFormatAndANewerVersionAreRefused) {
  ExpectOtherFormatsAreRefused(TemporaryFolder(), kFormat, 1, kRead);
}

TEST(CornerTracksIo, DamagedBytesAreSurvived) {
  const TemporaryFolder folder;
  WriteCornerTracks(folder / "t.h5", SomeTracks(), "size = 1\n");
  ExpectDamageIsSurvived(
      folder, folder / "t.h5", [](const std::filesystem::path& path) { ReadCornerTracks(path); });
}

class CornerTracksIoTest : public testing::Test {
 protected:
  void ExpectRefused(const std::function<void(CornerTracks&)>& damage,
                     const std::string& text) const {
    CornerTracks tracks = SomeTracks();
    damage(tracks);
    WriteCornerTracks(folder_ / "t.h5", tracks, "");
    NIGHTMAP_EXPECT_ERROR(DataError, ReadCornerTracks(folder_ / "t.h5"), "t.h5: field '" + text);
  }
  TemporaryFolder folder_;
};

TEST_F(CornerTracksIoTest, NanAndInfinityAreNamed) {
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    ExpectRefused([&](auto& tracks) { tracks.frames[1].sightings[1].px.y() = bad; }, "px'");
    ExpectRefused([&](auto& tracks) { tracks.frames[1].sightings[0].raw_px.x() = bad; }, "raw_px'");
    ExpectRefused([&](auto& tracks) { tracks.frames[2].median_displacement_px.x() = bad; },
                  "median_displacement_px'");
  }
}

TEST_F(CornerTracksIoTest, FramesThatCannotBeAreRefused) {
  ExpectRefused([](auto& tracks) { tracks.frames[3].frame_idx = 11; },
                "frame_idx' is not contiguous");
  ExpectRefused([](auto& tracks) { tracks.frames[3].time_ns = 100; }, "time_ns' has a time twice");
}

TEST_F(CornerTracksIoTest, TracksThatCannotBeAreRefused) {
  ExpectRefused(
      [](auto& tracks) {
        std::swap(tracks.frames[1].sightings[0].track_id, tracks.frames[1].sightings[1].track_id);
      },
      "track_id' does not ascend");
  const std::string gap = "track_id' has a track with a gap";
  ExpectRefused([](auto& tracks) { tracks.frames[0].sightings.clear(); }, gap);
  ExpectRefused(
      [](auto& tracks) { tracks.frames[1].sightings.erase(tracks.frames[1].sightings.begin()); },
      gap);
  ExpectRefused([](auto& tracks) { tracks.frames[2].sightings[1].track_id += 1 << 20; }, gap);
  // The id would be that of a frame beyond all integers.
  ExpectRefused([](auto& tracks) { tracks.frames[2].sightings[1].track_id += 1LL << 52; }, gap);
}

TEST_F(CornerTracksIoTest, EachTrackHasADescriptor) {
  const std::string text = "born_track_id' does not list the tracks in order";
  ExpectRefused([](auto& tracks) { tracks.descriptors.pop_back(); }, text);
  ExpectRefused([](auto& tracks) { tracks.descriptors.push_back({MakeTrackId(10, 0), {}}); }, text);
  ExpectRefused([](auto& tracks) { std::swap(tracks.descriptors[0], tracks.descriptors[1]); },
                text);
}

TEST_F(CornerTracksIoTest, AFileOfAnotherProgramIsRead) {
  Hdf5Writer file(folder_ / "t.h5", kFormat, 1, "", "");
  file.WriteList<std::int32_t>("frame_idx", {1});
  file.WriteList<std::int64_t>("time_ns", {5});
  file.Write("median_displacement_px", Array<float>{1, 2, {7, 8}});
  file.WriteList<std::uint8_t>("is_redetected", {1});
  file.WriteList<std::int64_t>("first_sighting", {0, 1});
  file.WriteList<std::int64_t>("track_id", {MakeTrackId(1, 0)});
  file.Write("raw_px", Array<float>{1, 2, {1, 2}});
  file.Write("px", Array<float>{1, 2, {3, 4}});
  file.WriteList<std::int64_t>("born_track_id", {MakeTrackId(1, 0)});
  file.Write("descriptor", Array<std::uint8_t>{1, 32, std::vector<std::uint8_t>(32, 9)});
  file.Close();
  const CornerTracks tracks = ReadCornerTracks(folder_ / "t.h5");
  EXPECT_EQ(tracks.frames.at(0).time_ns, 5);
  EXPECT_EQ(tracks.frames[0].median_displacement_px, Eigen::Vector2f(7, 8));
  EXPECT_EQ(tracks.frames[0].sightings.at(0).raw_px, Eigen::Vector2f(1, 2));
  EXPECT_EQ(tracks.frames[0].sightings[0].px, Eigen::Vector2f(3, 4));
  EXPECT_EQ(tracks.descriptors.at(0).orb[31], 9);
}

}  // namespace nightmap::corner_tracks_io_test
