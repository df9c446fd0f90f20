// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/pull_tight.h"

#include <gtest/gtest.h>

#include <set>

#include "stages/plan/plan/segment.h"
#include "tests/stages/plan/plan/random_routes.h"

namespace nightmap {
namespace pull_tight_test {

// Dense samples of the segment must lie in visited cells; the lengths add up.
TEST(Shorten, SegmentVisitsEveryCellItTouches) {
  Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const bool on_grid = i % 4 == 0;  // half-integer ends cross corners exactly
    const auto draw = [&] {
      const double value = random.Uniform(-9, 9);
      return on_grid ? std::floor(value) + 0.5 : value;
    };
    const Eigen::Vector2d a(draw(), draw());
    const Eigen::Vector2d b(draw(), draw());
    std::set<std::pair<int, int>> visited;
    double length = 0;
    VisitSegment(a, b, [&](const Eigen::Vector2i& cell, double part) {
      EXPECT_GE(part, -1e-9);
      visited.insert({cell.x(), cell.y()});
      length += part;
      return true;
    });
    EXPECT_NEAR(length, (b - a).norm(), 1e-9);
    for (int k = 0; k <= 1000; ++k) {
      const Eigen::Vector2d point = a + (b - a) * k / 1000;
      const Eigen::Vector2d nearest = point.array().round();
      if ((point - nearest).cwiseAbs().minCoeff() < 1e-9) continue;  // on a line of the grid
      EXPECT_TRUE(visited.count({static_cast<int>(std::floor(point.x())),
                                 static_cast<int>(std::floor(point.y()))}) > 0);
    }
  }
}

TEST(Shorten, CornerTouchesAllFourCells) {
  std::set<std::pair<int, int>> visited;
  VisitSegment({0.5, 0.5}, {1.5, 1.5}, [&](const Eigen::Vector2i& cell, double) {
    visited.insert({cell.x(), cell.y()});
    return true;
  });
  EXPECT_EQ(visited.size(), 4);
}

TEST(Shorten, StaysFreeAndIsNeverDearer) {
  int num_shorter = 0;
  ForRandomRoutes([&](const CostMap& map, const Points& route) {
    const Points tight = Shorten(map, route);
    const double cost = CostOf(map, tight);  // infinite where it is not free
    EXPECT_LE(cost, CostOf(map, route) + 1e-4);
    EXPECT_EQ(tight.front(), route.front());
    EXPECT_EQ(tight.back(), route.back());
    num_shorter += cost < CostOf(map, route) - 0.1 ? 1 : 0;
    for (const auto& dense = Resample(tight); const auto& point : dense) {
      EXPECT_TRUE(map.IsFree(point.array().floor().cast<int>()));
    }
  });
  EXPECT_GT(num_shorter, 30);
}

TEST(Shorten, ResampledPointsAreAtMostOneCellApart) {
  const auto points = Resample({{0.5, 0.5}, {7.3, 2.1}, {7.3, 3.1}});
  for (std::size_t i = 1; i < points.size(); ++i) {
    EXPECT_LE((points[i] - points[i - 1]).norm(), 1 + 1e-9);
  }
  EXPECT_EQ(points.back(), Eigen::Vector2d(7.3, 3.1));
}

}  // namespace pull_tight_test
}  // namespace nightmap
