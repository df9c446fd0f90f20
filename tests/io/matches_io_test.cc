// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/matches_io.h"

#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "pipeline/io/hdf5_file.h"
#include "tests/test_data.h"

namespace nightmap::matches_io_test {

FramePair RandomPair(int i) {
  Random random(1, static_cast<std::uint64_t>(i));
  FramePair pair;
  pair.frame_a = i;
  pair.frame_b = i + 1 + static_cast<int>(random.Index(9));
  pair.status = static_cast<PairStatus>(i % 6);
  pair.num_putative = static_cast<int>(random.Index(500));
  pair.score = random.Uniform();
  const Eigen::Quaterniond q(
      random.Gaussian(), random.Gaussian(), random.Gaussian(), random.Gaussian());
  pair.b_from_a = {q.normalized(), {random.Gaussian(), random.Gaussian(), random.Gaussian()}};
  for (double& value : pair.covariance.reshaped()) value = random.Gaussian();
  for (int k = 0; k < (i % 3) * 2; ++k) {
    pair.inliers.push_back(
        {static_cast<int>(random.Index(1000)), static_cast<int>(random.Index(1000))});
  }
  return pair;
}

TEST(MatchesIo, ReadsBackEveryField) {
  const TemporaryFolder folder;
  std::vector<FramePair> pairs;
  for (int i = 0; i < 12; ++i) pairs.push_back(RandomPair(i));
  WritePairs(folder / "m.h5", pairs, "x = 1\n");
  const auto read = ReadPairs(folder / "m.h5");
  ASSERT_EQ(read.size(), pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    EXPECT_EQ(read[i].frame_a, pairs[i].frame_a);
    EXPECT_EQ(read[i].frame_b, pairs[i].frame_b);
    EXPECT_EQ(read[i].status, pairs[i].status);
    EXPECT_EQ(read[i].num_putative, pairs[i].num_putative);
    EXPECT_EQ(read[i].score, pairs[i].score);
    EXPECT_EQ(read[i].b_from_a.Matrix(), pairs[i].b_from_a.Matrix());
    EXPECT_EQ(read[i].covariance, pairs[i].covariance);
    ASSERT_EQ(read[i].inliers.size(), pairs[i].inliers.size());
    for (std::size_t k = 0; k < pairs[i].inliers.size(); ++k) {
      EXPECT_EQ(read[i].inliers[k].a, pairs[i].inliers[k].a);
      EXPECT_EQ(read[i].inliers[k].b, pairs[i].inliers[k].b);
    }
  }
  WritePairs(folder / "again.h5", read, "x = 1\n");
  EXPECT_EQ(ReadBytes(folder / "again.h5"), ReadBytes(folder / "m.h5"));
}

TEST(MatchesIo, CountsInliersWithoutReadingThem) {
  const TemporaryFolder folder;
  std::vector<FramePair> pairs;
  for (int i = 0; i < 12; ++i) pairs.push_back(RandomPair(i));
  WritePairs(folder / "m.h5", pairs, "x = 1\n");
  std::vector<FramePair> again;
  for (const CountedPair& pair : ReadCountedPairs(folder / "m.h5")) {
    const std::vector<FeatureMatch>& inliers = pairs[again.size()].inliers;
    EXPECT_EQ(pair.num_inliers, static_cast<int>(inliers.size()));
    EXPECT_TRUE(pair.inliers.empty());
    again.push_back(pair);
    again.back().inliers = inliers;
  }
  WritePairs(folder / "again.h5", again, "x = 1\n");
  EXPECT_EQ(ReadBytes(folder / "again.h5"), ReadBytes(folder / "m.h5"));
}

TEST(MatchesIo, NoPairsAreFine) {
  const TemporaryFolder folder;
  WritePairs(folder / "m.h5", {}, "");
  EXPECT_TRUE(ReadPairs(folder / "m.h5").empty());
}

// Two pairs, three inliers in the first, as another program might write them.
struct Arrays {
  Array<std::int32_t> frame{2, 2, {0, 1, 0, 2}};
  std::vector<std::int32_t> status = {0, 2};
  std::vector<std::int32_t> num_putative = {9, 4};
  std::vector<double> score = {0, 0.5};
  Array<double> b_from_a{2, 7, {0, 0, 0, 0, 0, 0, 1, 1, 2, 3, 0, 0, 1, 0}};
  Array<double> covariance{2, 36, std::vector<double>(72, 0.1)};
  std::vector<std::int32_t> first_match = {0, 3, 3};
  Array<std::int32_t> match{3, 2, {0, 1, 2, 3, 4, 5}};

  void Write(const std::filesystem::path& path) const {
    Hdf5Writer file(path, "nightmap matches", 1, "", "");
    file.Write("frame", frame);
    file.WriteList("status", status);
    file.WriteList("num_putative", num_putative);
    file.WriteList("score", score);
    file.Write("b_from_a", b_from_a);
    file.Write("covariance", covariance);
    file.WriteList("first_match", first_match);
    file.Write("match", match);
    file.Close();
  }
};

class MatchesIoTest : public testing::Test {
 protected:
  void ExpectRefused(const std::function<void(Arrays&)>& damage, const std::string& text) const {
    Arrays arrays;
    arrays.Write(path_);
    ASSERT_EQ(ReadPairs(path_).size(), 2U);
    damage(arrays);
    arrays.Write(path_);
    NIGHTMAP_EXPECT_ERROR(DataError, ReadPairs(path_), "m.h5: " + text);
  }
  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "m.h5";
};

TEST_F(MatchesIoTest, NanAndInfinityAreNamed) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    ExpectRefused([&](Arrays& a) { a.score[1] = bad; }, "field 'score'");
    ExpectRefused([&](Arrays& a) { a.b_from_a.values[8] = bad; }, "field 'b_from_a'");
    ExpectRefused([&](Arrays& a) { a.covariance.values[71] = bad; }, "field 'covariance'");
  }
}

TEST_F(MatchesIoTest, ValuesOutOfRangeAreNamed) {
  using Frames = std::vector<std::int32_t>;
  for (const Frames& frames : {Frames{0, 1, 2, 2}, {1, 0, 0, 2}, {-1, 1, 0, 2}}) {
    ExpectRefused([&](Arrays& a) { a.frame.values = frames; }, "field 'frame'");
  }
  ExpectRefused([](Arrays& a) { a.status[0] = 6; }, "field 'status'");
  ExpectRefused([](Arrays& a) { a.status[1] = -1; }, "field 'status'");
  ExpectRefused([](Arrays& a) { a.num_putative[1] = -1; }, "field 'num_putative'");
  ExpectRefused([](Arrays& a) { a.match.values[4] = -1; }, "field 'match'");
  ExpectRefused([](Arrays& a) { a.match.values[5] = -1; }, "field 'match'");
  ExpectRefused([](Arrays& a) { a.b_from_a.values[13] = 0.5; }, "row 1 holds a quaternion");
}

}  // namespace nightmap::matches_io_test
