// SPDX-License-Identifier: Apache-2.0
#include "pipeline/laser/thin_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>

#include "pipeline/base/random.h"

namespace nightmap::thin_points_test {

using Points = std::vector<Eigen::Vector2d>;

Points RandomPoints(std::size_t count) {
  Random random(1);
  Points points;
  for (std::size_t i = 0; i < count; ++i) {
    points.emplace_back(random.Uniform(-2, 2), random.Uniform(-2, 2));
  }
  return points;
}

std::pair<double, double> CellOf(const Eigen::Vector2d& point, double cell_m) {
  return {std::floor(point.x() / cell_m), std::floor(point.y() / cell_m)};
}

TEST(ThinPoints, TheFirstPointOfEachCellInTheirOrder) {
  const Points points = RandomPoints(1000);
  for (const double cell_m : {0.1, 0.5, 10.0}) {
    Points expected;
    std::set<std::pair<double, double>> taken;
    for (const Eigen::Vector2d& point : points) {
      if (taken.insert(CellOf(point, cell_m)).second) expected.push_back(point);
    }
    EXPECT_EQ(ThinPoints(points, cell_m), expected);
    EXPECT_EQ(ThinPoints(expected, cell_m), expected);
  }
}

TEST(ThinPoints, CellsOnBothSidesOfTheOriginAreDifferent) {
  const Points points{{-0.01, 0.01}, {0.01, 0.01}, {0.01, -0.01}, {-0.01, -0.01}};
  EXPECT_EQ(ThinPoints(points, 0.1), points);
  EXPECT_EQ(ThinPoints({{0.01, 0.01}, {0.09, 0.09}, {0.1, 0.09}}, 0.1),
            (Points{{0.01, 0.01}, {0.1, 0.09}}));
}

TEST(ThinPoints, NoPointsStayNone) {
  EXPECT_TRUE(ThinPoints({}, 0.1).empty());
  EXPECT_TRUE(SpreadPoints({}, 0).empty());
  EXPECT_TRUE(SpreadPoints({}, 3).empty());
}

TEST(SpreadPoints, FewPointsStayAsTheyAre) {
  const Points points = RandomPoints(7);
  for (const std::size_t max_count : {7, 8, 1000}) {
    EXPECT_EQ(SpreadPoints(points, max_count), points);
  }
}

TEST(SpreadPoints, OfManyAsManyAsAllowedAtEvenStepsInTheirOrder) {
  Points points;
  for (int i = 0; i < 1000; ++i) points.emplace_back(i, 0);
  for (const std::size_t max_count : {1, 2, 7, 300, 999}) {
    const Points spread = SpreadPoints(points, max_count);
    ASSERT_EQ(spread.size(), max_count);
    const double step = 1000.0 / static_cast<double>(max_count);
    EXPECT_EQ(spread[0], points[0]);
    for (std::size_t i = 1; i < spread.size(); ++i) {
      EXPECT_NEAR(spread[i].x() - spread[i - 1].x(), step, 1);
    }
    EXPECT_GE(spread.back().x() + step + 1, 1000);
  }
  EXPECT_TRUE(SpreadPoints(points, 0).empty());
}

}  // namespace nightmap::thin_points_test
