// SPDX-License-Identifier: Apache-2.0
// A thousand random starts and goals on each of three maps, against a flood fill that shares no
// code with the planner.

#include <algorithm>
#include <cmath>
#include <optional>

#include "stages/plan/plan/plan.h"
#include "tests/stages/plan/plan/office_floor.h"
#include "tests/stages/plan/plan/planning.h"
#include "tests/stages/plan/plan/scene.h"

namespace nightmap::random_paths_test {

constexpr int kNumPairs = 1000;
constexpr double kRadius_m = 0.2;

// Cells that a robot must not touch; cells beyond the grid are among them.
bool IsBlocked(const OccupancyGrid& grid, int x, int y) {
  return !grid.Contains({x, y}) || grid.At({x, y}) != kFreeCell;
}

// Whether some cell that is blocked reaches nearer than the radius to a rectangle (in cells).
bool IsTouched(const OccupancyGrid& grid, const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  const double radius = kRadius_m / grid.resolution_m - 1e-6;
  const int reach = static_cast<int>(std::ceil(radius)) + 1;
  for (int y = static_cast<int>(low.y()) - reach; y <= static_cast<int>(high.y()) + reach; ++y) {
    for (int x = static_cast<int>(low.x()) - reach; x <= static_cast<int>(high.x()) + reach; ++x) {
      if (!IsBlocked(grid, x, y)) continue;
      const double gap_x = std::max({x - high.x(), low.x() - x - 1, 0.0});
      const double gap_y = std::max({y - high.y(), low.y() - y - 1, 0.0});
      if (std::hypot(gap_x, gap_y) < radius) return true;
    }
  }
  return false;
}

// Number of the part of the map that each cell belongs to; 0 where the robot does not fit.
std::vector<int> FloodFill(const OccupancyGrid& grid) {
  std::vector<int> parts(grid.cells.size(), -1);
  const auto fits = [&](int x, int y) {
    return !IsBlocked(grid, x, y) && !IsTouched(grid, {x, y}, {x + 1, y + 1});
  };
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      if (!fits(x, y)) parts[grid.Index(x, y)] = 0;
    }
  }
  int num_parts = 0;
  for (int i = 0; i < grid.width * grid.height; ++i) {
    if (parts[static_cast<std::size_t>(i)] != -1) continue;
    parts[static_cast<std::size_t>(i)] = ++num_parts;
    std::vector<Eigen::Vector2i> open = {{i % grid.width, i / grid.width}};
    while (!open.empty()) {
      const Eigen::Vector2i cell = open.back();
      open.pop_back();
      for (const auto& [dx, dy] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
        const Eigen::Vector2i next(cell.x() + dx, cell.y() + dy);
        if (!grid.Contains(next) || parts[grid.Index(next.x(), next.y())] != -1) continue;
        parts[grid.Index(next.x(), next.y())] = num_parts;
        open.push_back(next);
      }
    }
  }
  return parts;
}

struct Counts {
  int num_paths = 0;
  int num_unreachable = 0;
  int num_refused = 0;
  int num_points = 0;
};

Counts CheckPairs(const OccupancyGrid& grid, std::uint64_t seed) {
  const auto parts = FloodFill(grid);
  const auto part_at = [&](const Eigen::Vector2d& point) {
    const Eigen::Vector2i cell = grid.CellOf(point);
    return parts[grid.Index(cell.x(), cell.y())];
  };
  PlanOptions options = Between("", "", kRadius_m, 0);
  options.cost.max_hole_m = 0;
  Random random(seed);
  const auto draw = [&] {
    const auto draw_any = [&] {
      return Eigen::Vector2d(grid.origin_in_map +
                             grid.resolution_m * Eigen::Vector2d(random.Uniform(0, grid.width),
                                                                 random.Uniform(0, grid.height)));
    };
    Eigen::Vector2d point = draw_any();
    // One in eight may be where the robot does not fit.
    for (bool any = random.Index(8) == 0; !any && part_at(point) == 0;) point = draw_any();
    return point;
  };
  Counts counts;
  const PlanInputs inputs{grid, {}, {}};
  for (int i = 0; i < kNumPairs; ++i) {
    const Eigen::Vector2d start = draw();
    const Eigen::Vector2d goal = draw();
    options.start = TextOf(start);
    options.goal = TextOf(goal);
    options.planner = i % 2 == 0 ? "any_angle" : "astar";
    options.shorten = i % 4 < 2;
    std::string error;
    std::optional<PlanResult> result;
    try {
      result = Plan(options, inputs);
    } catch (const DataError& failure) {
      error = failure.what();
    }
    const bool fits = part_at(start) != 0 && part_at(goal) != 0;
    EXPECT_EQ(result.has_value(), fits && part_at(start) == part_at(goal))
        << options.start << " to " << options.goal << error;
    if (!result) {
      EXPECT_THAT(error, testing::HasSubstr(fits ? "no path" : "nearest free cell"));
      ++(fits ? counts.num_unreachable : counts.num_refused);
      continue;
    }
    ++counts.num_paths;
    for (std::size_t k = 0; k < result->path.size(); ++k) {
      const Eigen::Vector2d point = grid.ToCells(result->path[k].point_in_map);
      EXPECT_FALSE(IsTouched(grid, point, point)) << point.transpose();
      if (k == 0) continue;
      const Eigen::Vector2d before = grid.ToCells(result->path[k - 1].point_in_map);
      EXPECT_LE((point - before).norm(), 1 + 1e-6);
      const Eigen::Vector2d between = (point + before) / 2;
      EXPECT_FALSE(IsTouched(grid, between, between)) << between.transpose();
    }
    counts.num_points += static_cast<int>(result->path.size());
  }
  return counts;
}

TEST(RandomPaths, OfficeTurnedAgainstTheGrid) {
  const auto counts = CheckPairs(OfficeFloor(3, 13).ToGrid(16, 0.05, 0.35), 1);
  EXPECT_GT(counts.num_paths, 500);
  EXPECT_GT(counts.num_refused, 50);
  EXPECT_GT(counts.num_points, 20000);
}

TEST(RandomPaths, Clutter) {
  Random random(11);
  const auto counts = CheckPairs(RandomGrid(random, 200, 150, 0.01, 0.002), 2);
  EXPECT_GT(counts.num_paths, 100);
  EXPECT_GT(counts.num_unreachable, 100);
  EXPECT_GT(counts.num_points, 10000);
}

TEST(RandomPaths, RoomsSomeOfThemClosed) {
  Random random(7);
  OccupancyGrid grid = Building(random, 240, 60);
  FillCells(0, 120, 240, 123, kOccupiedCell, &grid);
  const auto counts = CheckPairs(grid, 3);
  EXPECT_GT(counts.num_paths, 100);
  EXPECT_GT(counts.num_unreachable, 100);
  EXPECT_GT(counts.num_points, 10000);
}

}  // namespace nightmap::random_paths_test
