// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/pull_tight.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <set>

#include "stages/plan/plan/segment.h"
#include "stages/plan/plan/theta_star.h"
#include "tests/stages/plan/plan/office_floor.h"
#include "tests/stages/plan/plan/reference_path.h"
#include "tests/stages/plan/plan/scene.h"

namespace nightmap::pull_tight_test {

// test(map, path) for the cheapest path between random ends of each of 300 small random maps, where
// there is one.
void ForRandomRoutes(const std::function<void(const CostMap&, const Points&)>& test) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE(seed);
    const CostMap map = RandomMap(seed);
    if (!HasFree(map)) continue;
    Random random(seed, 1);
    const Eigen::Vector2i start = RandomFreeCell(random, map);
    const Eigen::Vector2i goal = RandomFreeCell(random, map);
    const auto search = FindPath(map, start, goal, Steps::kCellToCell);
    if (!search.found) continue;
    const Points path = Centres(search.cells);
    ASSERT_TRUE(std::isfinite(CostOf(map, path)));
    test(map, path);
  }
}

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

TEST(Relax, StaysFreeKeepsItsEndsAndIsNeverDearer) {
  int num_cheaper = 0;
  ForRandomRoutes([&](const CostMap& map, const Points& path) {
    const Points relaxed = Relax(map, path);
    const double cost = CostOf(map, relaxed);  // infinite where it is not free
    EXPECT_LE(cost, CostOf(map, path) + 1e-9);
    EXPECT_EQ(relaxed.front(), path.front());
    EXPECT_EQ(relaxed.back(), path.back());
    num_cheaper += cost < CostOf(map, path) - 0.1 ? 1 : 0;
  });
  EXPECT_GT(num_cheaper, 30);
}

TEST(Relax, LeavesAPathOfOnePoint) {
  Random random(1);
  const CostMap map = MakeCostMap(RandomGrid(random, 20, 20, 0), {}, 0.1, 1);
  EXPECT_EQ(Relax(map, {{5.5, 5.5}}), (Points{{5.5, 5.5}}));
}

// A corridor 5 m wide, where all but the middle costs more: a path along its side is moved there.
TEST(Relax, FindsTheMiddleOfACorridor) {
  const CostMap map =
      MakeCostMap(FreeGrid(400, 50, 0.1), {.clearance_m = 2.4, .clearance_weight = 10}, 0.3, 1);
  const Points relaxed = Relax(map, {{10.5, 6.5}, {200.5, 6.5}, {390.5, 6.5}});
  for (const auto& point : relaxed) {
    if (std::abs(point.x() - 200) < 120) {
      EXPECT_NEAR(point.y(), 25, 2) << point.transpose();
    }
  }
}

// The pulled-tight path of the search is nearly the cheapest, whether the cost is the length or
// rises near obstacles. No path from cell to cell is.
TEST(Relax, TightPathsAreNearTheOptimum) {
  const auto grid = OfficeFloor(2, 24).ToGrid(30, 0.05, 0.2);
  for (const double clearance_weight : {0.0, 2.0}) {
    const CostMap map = MakeCostMap(grid, {.clearance_weight = clearance_weight}, 0.25, 1);
    Random random(5);
    double cost = 0;
    double optimum = 0;
    double cost_on_grid = 0;
    for (int num_paths = 0; num_paths < 6;) {
      const Eigen::Vector2i start = RandomFreeCell(random, map);
      const Eigen::Vector2i goal = RandomFreeCell(random, map);
      if ((goal - start).cast<double>().norm() < 200) continue;
      const auto to_goal = DijkstraCosts(map, goal);
      if (to_goal[map.Index(start)] < 0) continue;
      ++num_paths;
      const auto search = FindPath(map, start, goal, Steps::kAnyAngle);
      cost += CostOf(map, Tighten(map, Centres(search.cells)));
      optimum += CostOf(map, Tighten(map, Centres(ManyDirectionsPath(map, start, to_goal))));
      cost_on_grid += SearchCost::InCells(to_goal[map.Index(start)]);
    }
    EXPECT_LT(cost, 1.01 * optimum) << clearance_weight;
    EXPECT_LT(cost, 0.97 * cost_on_grid) << clearance_weight;
  }
}

}  // namespace nightmap::pull_tight_test
