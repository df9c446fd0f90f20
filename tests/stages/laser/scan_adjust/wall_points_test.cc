// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_adjust/wall_points.h"

#include <gtest/gtest.h>

#include "tests/laser_building.h"

namespace nightmap::wall_points_test {

using Points = std::vector<Eigen::Vector2d>;

// Points every step_m along a line, seen from the origin.
Points Line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double step_m) {
  Points points;
  const double length_m = (to - from).norm();
  for (double along_m = 0; along_m < length_m + 1e-9; along_m += step_m) {
    points.push_back(from + along_m / length_m * (to - from));
  }
  return points;
}

TEST(WallPoints, AWallFacesTheRobot) {
  for (const double turn_rad : {0.0, 0.7, 1.6, 3.0, 4.5}) {
    const Eigen::Rotation2Dd turn(turn_rad);
    const Points points = Line(turn * Eigen::Vector2d(2, -1), turn * Eigen::Vector2d(2, 1), 0.05);
    const auto found = FindWallPoints(points, 0.01);
    ASSERT_EQ(found.size(), points.size() - 6);  // three neighbours on each side
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i].point_in_robot, points[i + 3]);
      EXPECT_TRUE(found[i].normal_in_robot.isApprox(turn * Eigen::Vector2d(-1, 0), 1e-9));
    }
  }
}

TEST(WallPoints, AreAsFarApartAsAsked) {
  const Points points = Line({2, -1}, {2, 1}, 0.01);
  const auto found = FindWallPoints(points, 0.1);
  EXPECT_GE(found.size(), 18U);
  for (std::size_t i = 1; i < found.size(); ++i) {
    const double apart_m = (found[i].point_in_robot - found[i - 1].point_in_robot).norm();
    EXPECT_GE(apart_m, 0.1);
    EXPECT_LT(apart_m, 0.1101);
  }
}

TEST(WallPoints, FewerPointsThanALineNeedsAreNone) {
  EXPECT_TRUE(FindWallPoints({}, 0.05).empty());
  const Points six = Line({2, 0}, {2, 0.25}, 0.05);
  ASSERT_EQ(six.size(), 6U);
  EXPECT_TRUE(FindWallPoints(six, 0.01).empty());
  EXPECT_EQ(FindWallPoints(Line({2, 0}, {2, 0.3}, 0.05), 0.01).size(), 1U);
  EXPECT_TRUE(FindWallPoints(Points(20, Eigen::Vector2d(1, 1)), 0.01).empty());
}

TEST(WallPoints, AcrossACornerOrADoorThereIsNoWall) {
  Points corner = Line({2, -1}, {2, 1}, 0.05);
  for (const Eigen::Vector2d& point : Line({1.95, 1}, {0, 1}, 0.05)) corner.push_back(point);
  for (const WallPoint& found : FindWallPoints(corner, 0.01)) {
    const bool is_first = found.point_in_robot.x() == 2;
    const Eigen::Vector2d normal = is_first ? Eigen::Vector2d(-1, 0) : Eigen::Vector2d(0, -1);
    EXPECT_GT(found.normal_in_robot.dot(normal), 0.9) << found.point_in_robot.transpose();
    EXPECT_GT((found.point_in_robot - Eigen::Vector2d(2, 1)).norm(), 0.09);
  }
  Points door = Line({2, -2}, {2, -0.5}, 0.05);
  const std::size_t num_before = door.size();
  for (const Eigen::Vector2d& point : Line({2, 0.5}, {2, 2}, 0.05)) door.push_back(point);
  EXPECT_EQ(FindWallPoints(door, 0.01).size(), 2 * (num_before - 6));
}

TEST(WallPoints, FarAwayPointsMayBeFartherApart) {
  const auto count = [](double distance_m) {
    return FindWallPoints(Line({distance_m, -3}, {distance_m, 3}, 0.3), 0.01).size();
  };
  EXPECT_EQ(count(2), 0U);
  EXPECT_EQ(count(10), 21U - 6);
}

TEST(WallPoints, ClutterIsNoWallAndNoiseOfARangeIs) {
  Random random(1);
  for (const auto& [noise_m, is_wall] : {std::pair(0.02, true), {0.2, false}}) {
    Points points = Line({3, -2}, {3, 2}, 0.05);
    for (Eigen::Vector2d& point : points) point.x() += random.Uniform(-noise_m, noise_m);
    const auto found = FindWallPoints(points, 0.01);
    if (is_wall) {
      EXPECT_GT(found.size(), points.size() - 10);
      for (const WallPoint& point : found) {
        EXPECT_LT(point.normal_in_robot.x(), -0.9);
        EXPECT_NEAR(point.normal_in_robot.norm(), 1, 1e-9);
      }
    } else {
      EXPECT_LT(found.size(), points.size() / 10);
    }
  }
}

}  // namespace nightmap::wall_points_test
