// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/elastic_band.h"

#include <gtest/gtest.h>

#include "stages/plan/plan/pull_tight.h"
#include "stages/plan/plan/theta_star.h"
#include "tests/stages/plan/plan/office_floor.h"
#include "tests/stages/plan/plan/random_routes.h"

namespace nightmap {
namespace elastic_band_test {

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
  OccupancyGrid grid{400, 50, 0.1, Eigen::Vector2d::Zero(), {}};
  grid.cells.assign(400 * 50, kFreeCell);
  CostOptions options;
  options.clearance_m = 2.4;
  options.clearance_weight = 10;
  const CostMap map = MakeCostMap(grid, options, 0.3, 1);
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
    CostOptions options;
    options.clearance_weight = clearance_weight;
    const CostMap map = MakeCostMap(grid, options, 0.25, 1);
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

}  // namespace elastic_band_test
}  // namespace nightmap
