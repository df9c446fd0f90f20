// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_loops/unique_pose.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace nightmap::unique_pose_test {

using Points = std::vector<Eigen::Vector2d>;

// The walls of a room of 4 x 3 m about a place, with a niche in one of them; or a round one.
Points RoomAt(const Eigen::Vector2d& middle, bool has_niche) {
  Points points;
  if (!has_niche) {
    for (double angle = 0; angle < 2 * std::numbers::pi; angle += 0.03) {
      points.push_back(middle + 2 * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
    return points;
  }
  for (double s = 0; s < 4; s += 0.05) {
    points.push_back(middle + Eigen::Vector2d(s - 2, -1.5));
    points.push_back(middle + Eigen::Vector2d(s - 2, s > 2.5 && s < 3.5 ? 2.3 : 1.5));
    if (s < 3) points.push_back(middle + Eigen::Vector2d(-2, s - 1.5));
    if (s < 3) points.push_back(middle + Eigen::Vector2d(2, s - 1.5));
  }
  return points;
}

std::optional<BestPoses> Search(const Points& seen, const Points& points, double min_value) {
  LikelihoodField field({.resolution_m = 0.05, .half_extent_m = 10, .sigma_m = 0.06});
  field.Add(seen);
  SearchWindow window;
  window.half_extent_m = 8;
  window.half_angle_rad = std::numbers::pi;
  window.min_value = min_value;
  return SearchBestPoses(FieldPyramid(field, 5), points, window, 0.9);
}

TEST(UniquePose, ARoomOfItsOwnIsFoundAtOnePlace) {
  Points seen = RoomAt({-4, 0}, true);
  for (const Eigen::Vector2d& point : RoomAt({4, 2}, false)) seen.push_back(point);
  const auto found = Search(seen, RoomAt({0, 0}, true), 0.6);
  ASSERT_TRUE(found.has_value());
  EXPECT_LT((found->best.field_from_robot.translation - Eigen::Vector2d(-4, 0)).norm(), 0.1);
  EXPECT_FALSE(found->second.has_value());
}

TEST(UniquePose, OfTwoEqualRoomsTheOtherOneIsTheSecond) {
  Points seen = RoomAt({-4, 0}, true);
  for (const Eigen::Vector2d& point : RoomAt({4, 2}, true)) seen.push_back(point);
  const auto found = Search(seen, RoomAt({0, 0}, true), 0.6);
  ASSERT_TRUE(found.has_value());
  ASSERT_TRUE(found->second.has_value());
  const Eigen::Vector2d apart =
      found->best.field_from_robot.translation - found->second->field_from_robot.translation;
  EXPECT_NEAR(apart.norm(), std::hypot(8, 2), 0.2);
}

TEST(UniquePose, WhatFitsNowhereIsNotFound) {
  EXPECT_FALSE(Search(RoomAt({0, 0}, false), {{0.3, 0}, {0.5, 0.9}, {-0.7, 0.4}, {0, -0.6}}, 0.9));
}

}  // namespace nightmap::unique_pose_test
