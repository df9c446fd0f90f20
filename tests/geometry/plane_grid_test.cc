// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/plane_grid.h"

#include <gmock/gmock.h>

#include <limits>

#include "pipeline/base/random.h"

namespace nightmap::plane_grid_test {

std::vector<std::size_t> NearOneByOne(const std::vector<Eigen::Vector2d>& points,
                                      const Eigen::Vector2d& place,
                                      double radius_m) {
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if ((points[i] - place).norm() <= radius_m) near.push_back(i);
  }
  return near;
}

TEST(PlaneGrid, FindsThePointsThatASearchOfAllFinds) {
  Random random(1);
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 300; ++i) {
    points.emplace_back(random.Uniform(-20, 30), random.Uniform(-5, 5));
  }
  points[7] = points[8];
  const PlaneGrid grid(points, 1.5);
  std::size_t num_found = 0;
  for (const double radius_m :
       {0.0, 0.4, 1.5, 3.0, 17.0, std::numeric_limits<double>::infinity()}) {
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector2d place =
          i < 10 ? points[static_cast<std::size_t>(i)]
                 : Eigen::Vector2d(random.Uniform(-30, 40), random.Uniform(-10, 10));
      const auto near = grid.Near(place, radius_m);
      EXPECT_EQ(near, NearOneByOne(points, place, radius_m)) << radius_m;
      num_found += near.size();
    }
  }
  EXPECT_GT(num_found, 50 * points.size());
}

TEST(PlaneGrid, PointsOnTheRimAreNearAndOfCellsOfNegativeNumbersToo) {
  const PlaneGrid grid({{-1, -1}, {-2, -1}, {-1, 1}}, 1);
  EXPECT_THAT(grid.Near({-1, 0}, 1), testing::ElementsAre(0, 2));
  EXPECT_THAT(grid.Near({-1, -1}, 0), testing::ElementsAre(0));
  EXPECT_TRUE(PlaneGrid({}, 1).Near({0, 0}, 100).empty());
}

}  // namespace nightmap::plane_grid_test
