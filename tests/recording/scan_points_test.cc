// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/scan_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace nightmap {
namespace {

constexpr double kQuarterTurn_rad = std::numbers::pi / 2;

Signal Laser(const Rigid3& robot_from_sensor) {
  return {SignalKind::kScan, "laser", robot_from_sensor, {}};
}

// From the right over the front to the left, in quarter turns.
SignalSample Scan(std::vector<float> ranges_m) {
  return {7, {-kQuarterTurn_rad, kQuarterTurn_rad, 10}, std::move(ranges_m)};
}

TEST(ScanPoints, BeamsTurnCounterClockwiseFromTheFirstAngle) {
  const ScanPoints points = PointsInRobot(Scan({1, 2, 3, 4}), Laser({}));
  EXPECT_EQ(points.time_ns, 7);
  ASSERT_EQ(points.points_in_robot.size(), 4U);
  EXPECT_TRUE(points.points_in_robot[0].isApprox(Eigen::Vector3d(0, -1, 0)));
  EXPECT_TRUE(points.points_in_robot[1].isApprox(Eigen::Vector3d(2, 0, 0)));
  EXPECT_TRUE(points.points_in_robot[2].isApprox(Eigen::Vector3d(0, 3, 0)));
  EXPECT_TRUE(points.points_in_robot[3].isApprox(Eigen::Vector3d(-4, 0, 0)));
}

// Hangs upside down and looks backwards, 0.2 m ahead of the robot's origin.
TEST(ScanPoints, ThePoseOfTheSensorIsApplied) {
  const Rigid3 robot_from_sensor{
      Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitY())),
      {0.2, 0, 0.5}};
  const ScanPoints points = PointsInRobot(Scan({1, 2, 3}), Laser(robot_from_sensor));
  ASSERT_EQ(points.points_in_robot.size(), 3U);
  EXPECT_TRUE(points.points_in_robot[0].isApprox(Eigen::Vector3d(0.2, -1, 0.5)));
  EXPECT_TRUE(points.points_in_robot[1].isApprox(Eigen::Vector3d(-1.8, 0, 0.5)));
  EXPECT_TRUE(points.points_in_robot[2].isApprox(Eigen::Vector3d(0.2, 3, 0.5)));
}

TEST(ScanPoints, BeamsThatHitNothingGiveNoPointAndTurnTheOthersNot) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float nothing : {0.0f, -1.0f, nan, infinity, -infinity, 10.0f, 11.0f}) {
    const ScanPoints points = PointsInRobot(Scan({nothing, nothing, 9.5f}), Laser({}));
    ASSERT_EQ(points.points_in_robot.size(), 1U) << nothing;
    EXPECT_TRUE(points.points_in_robot[0].isApprox(Eigen::Vector3d(0, 9.5, 0)));
  }
  EXPECT_TRUE(PointsInRobot(Scan({}), Laser({})).points_in_robot.empty());
}

}  // namespace
}  // namespace nightmap
