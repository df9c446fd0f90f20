// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/odometry_io.h"

#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "pipeline/io/hdf5_file.h"
#include "tests/test_data.h"

namespace nightmap::odometry_io_test {

Rigid3 RandomPose(Random& random) {
  const Eigen::Quaterniond q(
      random.Gaussian(), random.Gaussian(), random.Gaussian(), random.Gaussian());
  return {q.normalized(), {random.Gaussian(), random.Gaussian(), random.Gaussian()}};
}

OdometryShard RandomShard() {
  Random random(1);
  OdometryShard shard;
  for (int i = 0; i < 9; ++i) {
    const auto state = static_cast<TrackingState>(i % 3);
    shard.frames.push_back({20 + i, RandomPose(random), state, i % 3 == 0});
  }
  for (int i = 0; i < 5; ++i) {
    PoseEdge edge{19 + i, 21 + 2 * i, RandomPose(random), Matrix6d::Zero(), i % 2 == 0};
    for (double& value : edge.covariance.reshaped()) value = random.Gaussian();
    shard.edges.push_back(edge);
  }
  shard.tracks.resize(4);
  for (int i = 0; i < 7; ++i) {
    shard.tracks[static_cast<std::size_t>(i / 2)].push_back(
        {20 + i, static_cast<int>(random.Index(1000))});
  }
  return shard;
}

TEST(OdometryIo, ReadsBackEveryField) {
  const TemporaryFolder folder;
  const OdometryShard shard = RandomShard();
  WriteOdometry(folder / "o.h5", shard, "x = 1\n");
  const OdometryShard read = ReadOdometry(folder / "o.h5");
  ASSERT_EQ(read.frames.size(), shard.frames.size());
  for (std::size_t i = 0; i < shard.frames.size(); ++i) {
    EXPECT_EQ(read.frames[i].frame_idx, shard.frames[i].frame_idx);
    EXPECT_EQ(read.frames[i].state, shard.frames[i].state);
    EXPECT_EQ(read.frames[i].is_keyframe, shard.frames[i].is_keyframe);
    EXPECT_EQ(read.frames[i].shard_from_camera.Matrix(),
              shard.frames[i].shard_from_camera.Matrix());
  }
  ASSERT_EQ(read.edges.size(), shard.edges.size());
  for (std::size_t i = 0; i < shard.edges.size(); ++i) {
    EXPECT_EQ(read.edges[i].frame_a, shard.edges[i].frame_a);
    EXPECT_EQ(read.edges[i].frame_b, shard.edges[i].frame_b);
    EXPECT_EQ(read.edges[i].b_from_a.Matrix(), shard.edges[i].b_from_a.Matrix());
    EXPECT_EQ(read.edges[i].covariance, shard.edges[i].covariance);
    EXPECT_EQ(read.edges[i].is_bridge, shard.edges[i].is_bridge);
  }
  EXPECT_EQ(read.tracks, shard.tracks);
  OdometryShard trackless = ReadOdometryWithoutTracks(folder / "o.h5");
  EXPECT_TRUE(trackless.tracks.empty());
  trackless.tracks = shard.tracks;
  WriteOdometry(folder / "again.h5", trackless, "x = 1\n");
  EXPECT_EQ(ReadBytes(folder / "again.h5"), ReadBytes(folder / "o.h5"));
  WriteOdometry(folder / "again.h5", read, "x = 1\n");
  EXPECT_EQ(ReadBytes(folder / "again.h5"), ReadBytes(folder / "o.h5"));
}

// Two frames, an edge between them, and a track seen in both, as another program might write them.
struct Arrays {
  std::vector<std::int32_t> frame_idx = {3, 4};
  std::vector<std::uint8_t> state = {0, 1};
  std::vector<std::uint8_t> is_keyframe = {1, 1};
  Array<double> shard_from_camera{2, 7, {0, 0, 0, 0, 0, 0, 1, 1, 2, 3, 0, 0, 1, 0}};
  Array<std::int32_t> edge_frame{1, 2, {3, 4}};
  Array<double> edge_b_from_a{1, 7, {1, 2, 3, 0, 0, 0, 1}};
  Array<double> edge_covariance{1, 36, std::vector<double>(36, 0.1)};
  std::vector<std::uint8_t> edge_is_bridge = {0};
  Array<std::int32_t> observation{2, 3, {0, 3, 7, 0, 4, 8}};

  void Write(const std::filesystem::path& path) const {
    Hdf5Writer file(path, "nightmap odometry", 1, "", "");
    file.WriteList("frame_idx", frame_idx);
    file.WriteList("state", state);
    file.WriteList("is_keyframe", is_keyframe);
    file.Write("shard_from_camera", shard_from_camera);
    file.Write("edge_frame", edge_frame);
    file.Write("edge_b_from_a", edge_b_from_a);
    file.Write("edge_covariance", edge_covariance);
    file.WriteList("edge_is_bridge", edge_is_bridge);
    file.Write("observation", observation);
    file.Close();
  }
};

class OdometryIoTest : public testing::Test {
 protected:
  void ExpectRefused(const std::function<void(Arrays&)>& damage, const std::string& text) const {
    Arrays arrays;
    arrays.Write(path_);
    ASSERT_EQ(ReadOdometry(path_).frames.size(), 2U);
    damage(arrays);
    arrays.Write(path_);
    NIGHTMAP_EXPECT_ERROR(DataError, ReadOdometry(path_), "o.h5: " + text);
  }
  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "o.h5";
};

TEST_F(OdometryIoTest, RowsOfATrackFollowEachOtherAndItsFramesAscend) {
  using Rows = std::vector<std::int32_t>;
  for (const Rows& rows : {Rows{1, 3, 7, 0, 4, 8}, {0, 4, 7, 0, 3, 8}, {0, 4, 7, 0, 4, 8}}) {
    ExpectRefused([&](Arrays& a) { a.observation.values = rows; }, "field 'observation'");
  }
}

TEST_F(OdometryIoTest, NanAndInfinityAreNamed) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    ExpectRefused([&](Arrays& a) { a.shard_from_camera.values[9] = bad; },
                  "field 'shard_from_camera'");
    ExpectRefused([&](Arrays& a) { a.edge_b_from_a.values[0] = bad; }, "field 'edge_b_from_a'");
    ExpectRefused([&](Arrays& a) { a.edge_covariance.values[35] = bad; },
                  "field 'edge_covariance'");
  }
}

TEST_F(OdometryIoTest, ValuesOutOfRangeAreNamed) {
  using Limits = std::numeric_limits<std::int32_t>;
  using Pair = std::vector<std::int32_t>;
  for (const Pair& idx : {Pair{3, 5}, {4, 3}, {-1, 0}, {Limits::max(), Limits::min()}}) {
    ExpectRefused([&](Arrays& a) { a.frame_idx = idx; }, "field 'frame_idx'");
  }
  ExpectRefused([](Arrays& a) { a.state[1] = 3; }, "field 'state'");
  for (const Pair& frames : {Pair{4, 3}, {4, 4}, {-1, 4}}) {
    ExpectRefused([&](Arrays& a) { a.edge_frame.values = frames; }, "field 'edge_frame'");
  }
  for (const std::size_t i : {0U, 1U, 5U}) {
    ExpectRefused([&](Arrays& a) { a.observation.values[i] = -1; }, "field 'observation'");
  }
  ExpectRefused([](Arrays& a) { a.shard_from_camera.values[12] = 0; }, "row 1 holds a quaternion");
  ExpectRefused([](Arrays& a) { a.edge_b_from_a.values[6] = 2; }, "row 0 holds a quaternion");
}

}  // namespace nightmap::odometry_io_test
