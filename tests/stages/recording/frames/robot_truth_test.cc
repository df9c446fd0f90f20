// SPDX-License-Identifier: Apache-2.0
#include "stages/recording/frames/robot_truth.h"

#include <numbers>

#include "pipeline/base/error.h"
#include "tests/test_data.h"

namespace nightmap::robot_truth_test {

constexpr double kQuarterTurn_rad = std::numbers::pi / 2;

class RobotTruthTest : public testing::Test {
 protected:
  RobotTruthTest() {
    site_.root = "lab";
    site_.robot_truth.source = "s.toml:9";
    signals_.push_back({SignalKind::kScan, "laser", {}, {}});
    signals_.push_back({SignalKind::kOdometry, "wheels", {}, {{1, {9, 9, 9}, {}}}});
    signals_.push_back({SignalKind::kOdometry,
                        "corrected",
                        {},
                        {{1, {0, 0, 0}, {}}, {2, {3, 4, kQuarterTurn_rad}, {}}}});
  }

  RobotTruth Take() { return TakeRobotTruth(site_, folder_.Path(), &signals_); }
  RobotTruth TakeRelations(const std::string& text) {
    site_.robot_truth.relations = "a.relations";
    folder_.Write("lab/a.relations", text);
    return Take();
  }

  TemporaryFolder folder_;
  SiteConfig site_;
  std::vector<Signal> signals_;
};

TEST_F(RobotTruthTest, ASiteMayHaveNone) {
  const RobotTruth truth = Take();
  EXPECT_TRUE(truth.truth_from_robot.empty() && truth.relations.empty());
  EXPECT_EQ(signals_.size(), 3u);
}

TEST_F(RobotTruthTest, TheSensorThatIsTheTruthIsNoOdometryAnyMore) {
  site_.robot_truth.odometry = "corrected";
  const RobotTruth truth = Take();
  ASSERT_EQ(signals_.size(), 2u);
  EXPECT_EQ(signals_[1].sensor_id, "wheels");
  ASSERT_EQ(truth.truth_from_robot.size(), 2u);
  EXPECT_EQ(truth.truth_from_robot[1].time_ns, 2);
  const Rigid3& pose = truth.truth_from_robot[1].pose;
  EXPECT_TRUE((pose * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(3, 5, 0)));
}

// The wheels' frame lies 1 m ahead of the robot's origin.
TEST_F(RobotTruthTest, ThePoseOfTheSensorOnTheRobotIsApplied) {
  site_.robot_truth.odometry = "corrected";
  signals_[2].robot_from_sensor.translation = {1, 0, 0};
  const auto poses = Take().truth_from_robot;
  EXPECT_TRUE(poses[0].pose.translation.isApprox(Eigen::Vector3d(-1, 0, 0)));
  EXPECT_TRUE(poses[1].pose.translation.isApprox(Eigen::Vector3d(3, 3, 0)));
}

TEST_F(RobotTruthTest, ATrajectoryIsReadAsItIs) {
  site_.robot_truth.trajectory = "truth.tum";
  folder_.Write("lab/truth.tum", "# t\n1.5 1 2 3 0 0 0 1\n2.5 4 5 6 0 0 0 1\n");
  const RobotTruth truth = Take();
  EXPECT_EQ(signals_.size(), 3u);
  ASSERT_EQ(truth.truth_from_robot.size(), 2u);
  EXPECT_EQ(truth.truth_from_robot[0].time_ns, 1'500'000'000);
  EXPECT_EQ(truth.truth_from_robot[1].pose.translation, Eigen::Vector3d(4, 5, 6));
}

TEST_F(RobotTruthTest, TimesOfATrajectoryMayHaveAnotherUnit) {
  site_.robot_truth = {"", "truth.tum", "ns", "", "s.toml:9"};
  folder_.Write("lab/truth.tum", "1305031102175304003 1 2 3 0 0 0 1\n");
  EXPECT_EQ(Take().truth_from_robot.at(0).time_ns, 1305031102175304003);
  site_.robot_truth.time_unit = "";
  NIGHTMAP_EXPECT_ERROR(DataError, Take(), "time_unit = \"ns\" in the table at s.toml:9");
}

TEST_F(RobotTruthTest, RelationsAreCheckedAndCopied) {
  const std::string text = "# a\n1.5 2.5 1 2 3 0.1 0.2 0.3\n2 1 0 0 0 0 0 -3.1\n";
  const RobotTruth truth = TakeRelations(text);
  EXPECT_EQ(truth.relations, text);
  EXPECT_EQ(truth.num_relations, 2u);
  const auto expect = [&](const std::string& line, const std::string& why) {
    NIGHTMAP_EXPECT_ERROR(DataError, TakeRelations("# a\n" + line + "\n"), "a.relations:2: " + why);
    NIGHTMAP_EXPECT_ERROR(DataError,
                          TakeRelations("# a\n" + line + "\n"),
                          "repair the file or correct `relations` in s.toml:9");
  };
  expect("1 2 3", "3 columns, expected 8");
  expect("1 2 0 0 0 0 0 nan", "'nan' is not a finite number");
  expect("1 now 0 0 0 0 0 0", "'now' is not a time");
  expect("1 2 1e30 0 0 0 0 0", "1e30 is too far");
}

TEST_F(RobotTruthTest, WhatHoldsNoTruthIsNamed) {
  NIGHTMAP_EXPECT_ERROR(DataError, TakeRelations("# none\n"), "a.relations: holds no relation");
  site_.robot_truth = {"corrected", "", "", "", "s.toml:9"};
  signals_[2].samples.clear();
  NIGHTMAP_EXPECT_ERROR(DataError, Take(), "s.toml:9: the sensor \"corrected\" has no sample");
  site_.robot_truth = {"", "truth.tum", "", "", "s.toml:9"};
  NIGHTMAP_EXPECT_ERROR(DataError, Take(), "truth.tum");
  folder_.Write("lab/truth.tum", "# none\n");
  NIGHTMAP_EXPECT_ERROR(
      DataError, Take(), "truth.tum: holds no pose: correct `trajectory` in s.toml:9");
  folder_.Write("lab/truth.tum", "1 2 3\n");
  NIGHTMAP_EXPECT_ERROR(DataError, Take(), "truth.tum:1: ");
}

}  // namespace nightmap::robot_truth_test
