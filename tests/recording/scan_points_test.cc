// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/scan_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace nightmap::scan_points_test {

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

// A scan of 720 beams, taken in 0.075 s by a robot that turns at 1 rad/s in the middle of a square
// room of 10 m; its laser is 0.3 m ahead of its centre and looks to the left.
struct TurningRobot {
  static constexpr double kSpeed_rad_per_s = 1, kHalf_m = 5;
  static constexpr int kNumBeams = 720;
  Signal laser =
      Laser({Eigen::Quaterniond(Eigen::AngleAxisd(1.2, Eigen::Vector3d::UnitZ())), {0.3, 0, 0.2}});
  SignalSample scan{7, {-3, 2 * std::numbers::pi / kNumBeams, 30}, {}};

  TurningRobot() {
    laser.scan_duration_s = 0.075;
    for (int i = 0; i < kNumBeams; ++i) {
      const double turn_rad = kSpeed_rad_per_s * laser.scan_duration_s * i / kNumBeams;
      const double angle_rad = turn_rad + 1.2 + scan.value[0] + i * scan.value[1];
      const Eigen::Vector2d from(0.3 * std::cos(turn_rad), 0.3 * std::sin(turn_rad));
      const Eigen::Vector2d direction(std::cos(angle_rad), std::sin(angle_rad));
      double range_m = 1e9;
      for (int k = 0; k < 2; ++k) {
        const double wall_m = direction[k] > 0 ? kHalf_m : -kHalf_m;
        if (direction[k] != 0) range_m = std::min(range_m, (wall_m - from[k]) / direction[k]);
      }
      scan.ranges_m.push_back(static_cast<float>(range_m));
    }
  }

  Rigid3 StartFromEnd() const {
    const Eigen::AngleAxisd turn(kSpeed_rad_per_s * laser.scan_duration_s,
                                 Eigen::Vector3d::UnitZ());
    return {Eigen::Quaterniond(turn), {0, 0, 0}};
  }

  static double LargestDistanceToAWall_m(const ScanPoints& points) {
    double largest_m = 0;
    for (const Eigen::Vector3d& point : points.points_in_robot) {
      largest_m = std::max(largest_m, std::abs(point.head<2>().cwiseAbs().maxCoeff() - kHalf_m));
    }
    return largest_m;
  }
};

TEST(ScanPoints, TheMotionOverAScanIsTakenBack) {
  const TurningRobot robot;
  const ScanPoints moved = PointsInRobot(robot.scan, robot.laser, robot.StartFromEnd());
  ASSERT_EQ(moved.points_in_robot.size(), 720U);
  EXPECT_EQ(moved.time_ns, 7);
  EXPECT_LT(TurningRobot::LargestDistanceToAWall_m(moved), 0.001);
  EXPECT_GT(TurningRobot::LargestDistanceToAWall_m(PointsInRobot(robot.scan, robot.laser)), 0.1);
}

TEST(ScanPoints, ARobotThatStandsStillNeedsNoMotion) {
  const TurningRobot robot;
  const auto still = PointsInRobot(robot.scan, robot.laser, {}).points_in_robot;
  EXPECT_EQ(still, PointsInRobot(robot.scan, robot.laser).points_in_robot);
}

}  // namespace nightmap::scan_points_test
