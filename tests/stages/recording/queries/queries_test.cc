// SPDX-License-Identifier: Apache-2.0
#include "stages/recording/queries/queries.h"

#include <gtest/gtest.h>

#include "pipeline/base/error.h"
#include "tests/test_data.h"

namespace nightmap::queries_test {

FrameRecord HeldOut(int frame_idx, std::int64_t time_ns) {
  FrameRecord frame;
  frame.frame_idx = frame_idx;
  frame.time_ns = time_ns;
  frame.color = {fmt::format("held/{}.png", frame_idx), "ab"};
  return frame;
}

RawSequence Query(const std::vector<std::int64_t>& times_ns) {
  RawSequence sequence;
  sequence.is_query = true;
  for (const std::int64_t time_ns : times_ns) {
    RawFrame& frame = sequence.frames.emplace_back();
    frame.time_ns = time_ns;
    frame.color = {fmt::format("q/{}.png", time_ns), "cd"};
  }
  return sequence;
}

StampedPose At(std::int64_t time_ns, double x_m) {
  return {time_ns, {Eigen::Quaterniond::Identity(), {x_m, 0, 0}}};
}

TEST(RunQueries, PicturesJoinTheHeldOutFramesByTime) {
  auto query = Query({25, 75});
  query.ground_truth = {At(75, 7)};
  const auto lists = RunQueries({HeldOut(0, 50), HeldOut(1, 100)}, {At(100, 9)}, {query}, 3);
  ASSERT_EQ(lists.queries.size(), 4u);
  std::vector<std::string> paths;
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(lists.queries[i].frame_idx, static_cast<int>(i));
    paths.push_back(lists.queries[i].color.path);
  }
  EXPECT_EQ(paths, (std::vector<std::string>{"q/25.png", "held/0.png", "q/75.png", "held/1.png"}));
  EXPECT_EQ(lists.queries[0].sequence_idx, 3);  // after the recordings
  EXPECT_EQ(lists.queries[1].sequence_idx, 0);
  ASSERT_EQ(lists.ground_truth.size(), 2u);
  EXPECT_EQ(lists.ground_truth[0].pose.translation.x(), 7);
  EXPECT_EQ(lists.ground_truth[1].pose.translation.x(), 9);
}

TEST(RunQueries, ADamagedPictureIsReportedAndStaysAQuery) {
  auto query = Query({25, 75});
  query.frames[0].problem = "q/25.png: truncated";
  const auto lists = RunQueries({}, {}, {query}, 0);
  EXPECT_EQ(lists.queries.size(), 2u);
  EXPECT_EQ(lists.skipped, std::vector<std::string>{"q/25.png: truncated"});
}

TEST(RunQueries, TwoOfOneTimeAreRefused) {
  NIGHTMAP_EXPECT_ERROR(DataError,
                        RunQueries({HeldOut(0, 50)}, {}, {Query({50})}, 1),
                        "queries held/0.png and q/50.png have the same time");
}

TEST(QueriesOptions, DefaultConfigFileIsWhatTheProgramHas) {
  QueriesOptions options, from_file;
  RegisterOptions(from_file).ParseToml(ReadBytes("configs/recording/default/queries.toml"),
                                       "queries.toml");
  EXPECT_EQ(RegisterOptions(from_file).ToToml(), RegisterOptions(options).ToToml());
}

}  // namespace nightmap::queries_test
