// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/no_path.h"

#include <algorithm>
#include <optional>

#include "pipeline/base/random.h"
#include "stages/plan/plan/narrow_places.h"
#include "stages/plan/plan/path_output.h"
#include "stages/plan/plan/widest_way.h"
#include "tests/stages/plan/plan/planning.h"
#include "tests/stages/plan/plan/scene.h"

namespace nightmap::no_path_test {

// Two rooms of 2 m joined by a door of `door_cells` cells of 10 cm in a wall 20 cm thick.
OccupancyGrid TwoRooms(int door_cells) {
  OccupancyGrid grid = FreeGrid(42, 20, 0.1, {1, 2});
  FillCells(20, 0, 22, 20, kOccupiedCell, &grid);
  FillCells(20, 8, 22, 8 + door_cells, kFreeCell, &grid);
  return grid;
}

PlanOptions Through(double radius_m) { return Between("1.55,3.05", "4.65,3.05", radius_m, 0); }

PlanInputs On(const OccupancyGrid& grid) { return {grid, {}, {}}; }

// Least number over which a robot of a radius goes from one cell to the other, by trial.
std::optional<double> WidestByTrial(const OccupancyGrid& grid,
                                    const CostMap& map,
                                    const Eigen::Vector2i& from,
                                    const Eigen::Vector2i& to) {
  std::optional<double> widest;
  const auto enough =
      static_cast<int>(std::ceil(std::pow(map.robot_radius_m / map.resolution_m, 2)));
  for (int squared = 0; squared <= enough; ++squared) {
    const double radius_m = map.resolution_m * std::sqrt(squared);
    const CostMap other = MakeCostMap(grid, {}, radius_m, 1);
    const auto labels = LabelReachable(other);
    const std::int32_t label = labels[other.Index(from)];
    if (label != 0 && label == labels[other.Index(to)]) widest = radius_m;
  }
  return widest;
}

TEST(Bottleneck, IsTheWidestByTrialOfAllRadii) {
  Random random(5);
  int num_found = 0;
  std::size_t num_places = 0;
  for (int i = 0; i < 60; ++i) {
    const OccupancyGrid grid = RandomGrid(random, 24, 17, 0.03, 0.02);
    const CostMap map = MakeCostMap(grid, {}, 0.25, 1);
    const Eigen::Vector2i from(2, 3), to(20, 12);
    const auto found = FindBottlenecks(map, from, to);
    const auto expected = WidestByTrial(grid, map, from, to);
    ASSERT_EQ(found.empty(), !expected || *expected > 0.25 - 1e-9) << i;
    if (found.empty()) continue;
    ++num_found;
    num_places += found.size();
    for (const Bottleneck& place : found) {
      EXPECT_DOUBLE_EQ(map.Clearance_m(place.cell), place.clearance_m);
      EXPECT_LT(place.clearance_m, 0.25);
    }
    // No radius between two that differ in a cell's squared distance.
    const auto least = std::ranges::min_element(found, {}, &Bottleneck::clearance_m);
    EXPECT_NEAR(least->clearance_m, *expected, 1e-9);
  }
  EXPECT_GT(num_found, 20);
  EXPECT_GT(num_places, 30U);
}

TEST(NoPath, MessageSaysWhichRobotWouldPassAndWhere) {
  const OccupancyGrid grid = TwoRooms(5);
  EXPECT_GT(Plan(Through(0.2), On(grid)).path.size(), 30U);
  ExpectError(Through(0.3), On(grid), {"for a robot of radius 0.200", "3.050"});
  ExpectError(Through(0.3), On(TwoRooms(0)), {"obstacles and unseen space part them"});
}

std::size_t NumPixels(const ColorImage& image, const std::array<std::uint8_t, 3>& color) {
  std::size_t count = 0;
  for (std::size_t i = 0; i + 2 < image.pixels.size(); i += 3) {
    count += std::equal(color.begin(), color.end(), image.pixels.begin() + static_cast<long>(i));
  }
  return count;
}

TEST(NoPath, PictureShowsWhatEachEndReaches) {
  const OccupancyGrid grid = TwoRooms(5);
  const auto areas = [&](const std::string& goal) {
    PlanOptions options = Through(0.3);
    options.goal = goal;
    const ColorImage picture = DrawNoPath(options, On(grid), 1);
    EXPECT_EQ(picture.width, PixelsPerCell(grid) * grid.width);
    return std::array{NumPixels(picture, {190, 230, 195}),
                      NumPixels(picture, {245, 200, 195}),
                      NumPixels(picture, {205, 220, 245})};
  };
  const auto [start, goal, other] = areas("4.65,3.05");
  EXPECT_GT(start, 10000U);
  EXPECT_GT(goal, 10000U);
  EXPECT_EQ(other, 0U);
  // A goal in the wall reaches nothing.
  const auto [of_start, of_goal, of_none] = areas("3.05,2.25");
  EXPECT_GT(of_start, 10000U);
  EXPECT_EQ(of_goal, 0U);
  EXPECT_GT(of_none, 10000U);
  EXPECT_EQ(areas("1e200,-1e200")[1], 0U);
}

TEST(Margin, IsKeptWhereThereIsAnotherWay) {
  // The straight way leads through a door as wide as the robot, another one is 1 m farther.
  OccupancyGrid grid = TwoRooms(5);
  const auto at_wall_m = [&](double margin_m) {
    PlanOptions options = Through(0.2);
    options.start = "2.25,3.05";
    options.goal = "4.05,3.05";
    options.cost.margin_m = margin_m;
    const PlanResult result = Plan(options, On(grid));
    double y_m = 0;
    for (const PathPoint& point : result.path) {
      if (std::abs(point.point_in_map.x() - 3.1) < 0.06) y_m = point.point_in_map.y();
    }
    return std::pair(y_m, result.narrow_places);
  };
  const auto narrow = at_wall_m(0.05);
  EXPECT_NEAR(narrow.first, 3.05, 0.01);
  ASSERT_EQ(narrow.second.size(), 1U);
  EXPECT_NEAR(narrow.second[0].room_m, 0, 1e-9);
  EXPECT_NEAR(narrow.second[0].narrowest_in_map.x(), 3.1, 0.2);
  EXPECT_GT(narrow.second[0].length_m, 0.2);
  FillCells(20, 0, 22, 7, kFreeCell, &grid);
  EXPECT_NEAR(at_wall_m(0).first, 3.05, 0.01);
  const auto wide = at_wall_m(0.05);
  EXPECT_LT(wide.first, 2.7);
  EXPECT_TRUE(wide.second.empty());
}

TEST(NarrowPlaces, AreStretchesWithTooLittleRoom) {
  std::vector<PathPoint> path(7);
  const std::array<double, 7> clearances_m = {0.3, 0.24, 0.21, 0.23, 0.25, 0.2, 0.4};
  for (std::size_t i = 0; i < path.size(); ++i) {
    path[i].distance_m = 0.1 * static_cast<double>(i);
    path[i].point_in_map.x() = path[i].distance_m;
    path[i].clearance_m = clearances_m[i];
  }
  const auto places = FindNarrowPlaces(path, 0.2, 0.05);
  ASSERT_EQ(places.size(), 2U);
  EXPECT_EQ(places[0].first_point, 1U);
  EXPECT_EQ(places[0].last_point, 3U);
  EXPECT_NEAR(places[0].length_m, 0.2, 1e-12);
  EXPECT_NEAR(places[0].narrowest_in_map.x(), 0.2, 1e-12);
  EXPECT_NEAR(places[0].room_m, 0.01, 1e-12);
  EXPECT_EQ(places[1].first_point, 5U);
  EXPECT_TRUE(FindNarrowPlaces(path, 0.2, 0).empty());
}

// A cell that no ray told anything of closes a door two cells wider than the robot, unless it
// counts as a hole.
TEST(Holes, AreCrossedUnlessTheyCountAsWalls) {
  OccupancyGrid grid = TwoRooms(7);
  grid.cells[grid.Index(21, 11)] = kUnknownCell;
  PlanOptions options = Through(0.3);
  const PlanResult result = Plan(options, On(grid));
  EXPECT_EQ(result.num_hole_cells, 1U);
  options.cost.max_hole_m = 0;
  ExpectError(options, On(grid), {"no path"});
}

}  // namespace nightmap::no_path_test
