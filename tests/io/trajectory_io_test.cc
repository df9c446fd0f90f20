// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/trajectory_io.h"

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "tests/test_data.h"

namespace nightmap::trajectory_io_test {

TEST(Time, IsExactToTheNanosecond) {
  EXPECT_EQ(ParseTime_ns("1305031102.175304"), 1305031102175304000);
  EXPECT_EQ(TimeToString(1305031102175304000), "1305031102.175304");
  EXPECT_EQ(TimeToString(1305031102175304001), "1305031102.175304001");
  EXPECT_EQ(ParseTime_ns("0.3"), 300000000);
  EXPECT_EQ(ParseTime_ns("7"), 7000000000);
  EXPECT_EQ(ParseTime_ns("1.305031102175304e+09"), 1305031102175304000);
  EXPECT_EQ(ParseTime_ns("1403636579763555584e-9"), 1403636579763555584);
  EXPECT_EQ(ParseTime_ns("0.0000000004"), 0);
  EXPECT_EQ(ParseTime_ns("0.0000000005"), 1);
  EXPECT_EQ(ParseTime_ns("-1.5"), -1500000000);
}

TEST(Time, OtherUnitsAreExactToo) {
  EXPECT_EQ(ParseTime_ns("1305031102175304003", TimeUnit::kNs), 1305031102175304003);
  EXPECT_EQ(ParseTime_ns("9223372036854775806", TimeUnit::kNs), 9223372036854775806);
  EXPECT_EQ(ParseTime_ns("1305031102175304", TimeUnit::kUs), 1305031102175304000);
  EXPECT_EQ(ParseTime_ns("1305031102175.304003", TimeUnit::kMs), 1305031102175304003);
  EXPECT_EQ(ParseTime_ns("1.3050311021753040e18", TimeUnit::kNs), 1305031102175304000);
  EXPECT_EQ(ParseTime_ns("-0.5", TimeUnit::kNs), -1);
  NIGHTMAP_EXPECT_ERROR(DataError, ParseTime_ns("x", TimeUnit::kMs), "'x' is not a time in ms");
  NIGHTMAP_EXPECT_ERROR(
      DataError, ParseTime_ns("1305031102175304003", TimeUnit::kUs), "it must be in us");
  NIGHTMAP_EXPECT_ERROR(
      DataError, ParseTime_ns("9223372036854775808", TimeUnit::kNs), "it must be in ns");
}

TEST(Time, TextRoundTripsForAnyTime) {
  Random random(1);
  for (int i = 0; i < 10000; ++i) {
    const auto time_ns = static_cast<std::int64_t>(random.Next() >> (1 + random.Index(60)));
    ASSERT_EQ(ParseTime_ns(TimeToString(time_ns)), time_ns);
    ASSERT_EQ(ParseTime_ns(TimeToString(-time_ns)), -time_ns);
  }
}

TEST(Time, RefusesWhatIsNoTime) {
  for (const char* text : {"",
                           ".",
                           "-",
                           "1.2.3",
                           "nan",
                           "inf",
                           "1e",
                           "1e99",
                           "0x10",
                           "1,5",
                           "1 ",
                           "1e-9223372036854775808"}) {
    EXPECT_THROW(ParseTime_ns(text), DataError) << text;
  }
  EXPECT_THROW(ParseTime_ns("1305031102175304000"), DataError);    // nanoseconds given as seconds
  EXPECT_THROW(ParseTime_ns("9223372036.8547758079"), DataError);  // rounds to 2^63
}

std::vector<StampedPose> RandomPoses(int count) {
  Random random(2);
  std::vector<StampedPose> poses;
  for (int i = 0; i < count; ++i) {
    const Eigen::Quaterniond q(
        random.Gaussian(), random.Gaussian(), random.Gaussian(), random.Gaussian());
    poses.push_back({1305031102175304000 + i * std::int64_t{33333333},
                     {q.normalized(), {random.Gaussian(), random.Gaussian(), -random.Gaussian()}}});
  }
  return poses;
}

class Tum : public InFolder {};

TEST_F(Tum, WhatIsWrittenIsRead) {
  const auto poses = RandomPoses(100);
  const auto path = folder_.Write("a.tum", TrajectoryToTum(poses, "map_from_camera"));
  const auto read = ReadTum(path);
  ASSERT_EQ(read.size(), poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(read[i].time_ns, poses[i].time_ns);
    EXPECT_LT((read[i].pose.translation - poses[i].pose.translation).norm(), 1e-8);
    EXPECT_LT(AngleBetween_rad(read[i].pose, poses[i].pose), 1e-7);
    EXPECT_EQ(FindPose(read, poses[i].time_ns), static_cast<int>(i));
  }
  EXPECT_EQ(FindPose(read, poses[3].time_ns + 1), -1);
  EXPECT_EQ(FindPose(read, poses[99].time_ns + 1), -1);
  // Writing what was read changes nothing any more.
  const auto again = folder_.Write("b.tum", TrajectoryToTum(read, "map_from_camera"));
  EXPECT_EQ(TrajectoryToTum(ReadTum(again), "map_from_camera"), ReadBytes(again));
}

TEST_F(Tum, EqualRotationsGiveEqualText) {
  StampedPose pose{0, {Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5), {-1e-12, 0, 0}}};
  const std::string text = TrajectoryToTum({pose}, "");
  pose.pose.rotation.coeffs() *= -1;
  pose.pose.translation.x() = 0;
  EXPECT_EQ(TrajectoryToTum({pose}, ""), text);
}

TEST_F(Tum, CommentsBlankLinesAndTabsAreFine) {
  const auto poses =
      ReadTum(folder_.Write("a.tum", "# comment\n\n1\t0 0 0  0 0 0 1\r\n  2 1 2 3 0 0 0 1"));
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[1].pose.translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(ReadTum(folder_.Write("b.tum", "# nothing\n")).empty());
}

TEST_F(Tum, ATrajectoryOfAStageHoldsAPose) {
  EXPECT_EQ(ReadPoses(folder_.Write("one.tum", "1 0 0 0 0 0 0 1\n")).size(), 1U);
  for (const char* text : {"", "# map_from_camera\n"}) {
    NIGHTMAP_EXPECT_ERROR(DataError,
                          ReadPoses(folder_.Write("none.tum", text)),
                          "none.tum: holds no pose; delete it and run make again");
  }
}

TEST(PoseAt, InterpolatesBetweenNeighboursThatAreCloseEnough) {
  const auto yaw = [](double yaw_rad) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()));
  };
  const std::vector<StampedPose> poses = {{100, {yaw(0.2), {1, 0, 0}}},
                                          {200, {yaw(0.6), {3, 4, 0}}}};
  const auto pose = PoseAt(poses, 125, 100);
  ASSERT_TRUE(pose);
  EXPECT_TRUE(pose->translation.isApprox(Eigen::Vector3d(1.5, 1, 0)));
  EXPECT_NEAR(pose->rotation.angularDistance(yaw(0.3)), 0, 1e-7);
  EXPECT_FALSE(PoseAt(poses, 125, 99));
  EXPECT_EQ(PoseAt(poses, 200, 0)->translation, poses[1].pose.translation);
  EXPECT_FALSE(PoseAt(poses, 99, 1000));
  EXPECT_FALSE(PoseAt(poses, 201, 1000));
  EXPECT_FALSE(PoseAt({}, 1, 1000));
}

TEST_F(Tum, BadLinesAreNamed) {
  const auto expect = [&](const std::string& line, const std::string& reason) {
    const auto path = folder_.Write("bad.tum", "# header\n1 0 0 0 0 0 0 1\n" + line + "\n");
    NIGHTMAP_EXPECT_ERROR(DataError, ReadTum(path), "bad.tum:3: ", reason);
  };
  expect("2 0 0 0 0 0 0", "7 columns");
  expect("2 0 0 0 0 0 0 1 5", "9 columns");
  expect("2 nan 0 0 0 0 0 1", "'nan' is not a finite number");
  expect("2 0 inf 0 0 0 0 1", "'inf' is not a finite number");
  expect("2 0 0 x 0 0 0 1", "'x'");
  expect("2 1e308 0 0 0 0 0 1", "farther than 1000000000 m");
  expect("2 0 0 0 0 0 0 0", "quaternion");
  expect("2 0 0 0 0 0 0 2", "quaternion");
  expect("x 0 0 0 0 0 0 1", "not a time");
  expect("1 0 0 0 0 0 0 1", "times must increase");
  expect("0.5 0 0 0 0 0 0 1", "times must increase");
  NIGHTMAP_EXPECT_ERROR(DataError, ReadTum(folder_ / "none.tum"), "none.tum");
}

}  // namespace nightmap::trajectory_io_test
