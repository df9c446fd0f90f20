// SPDX-License-Identifier: Apache-2.0
// No path leads over the tables and cabinets of synthetic buildings.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "pipeline/world/route.h"
#include "stages/plan/plan/plan.h"
#include "tests/stages/dense/grid/carver.h"
#include "tests/test_data.h"
#include "tests/world/two_floors.h"

namespace nightmap::furniture_test {

// Columns within a cell of a box's border may be the floor beside it.
constexpr double kBorder_m = 0.05;
constexpr double kHidden_m = 0.65;  // a step, max_hidden_m, and a voxel

bool IsFurniture(SurfaceLabel label) {
  switch (label) {
    case SurfaceLabel::kTable:
    case SurfaceLabel::kShelf:
    case SurfaceLabel::kCabinet:
    case SurfaceLabel::kBed:
    case SurfaceLabel::kSofa:
      return true;
    default:
      return false;
  }
}

// Whether a robot that stands at a point of a floor would be in a piece of furniture whose lower
// side is lower than `max_low_m` above the floor and whose upper side is higher than `min_high_m`.
bool IsInFurniture(const SyntheticWorld& world,
                   const Eigen::Vector2d& point,
                   double floor_m,
                   double max_low_m,
                   double min_high_m) {
  return std::ranges::any_of(world.scene.boxes, [&](const Box& box) {
    Box inner = box;
    inner.half_size.head<2>().array() -= kBorder_m;
    const double low_m = box.center.z() - box.half_size.z() - floor_m;
    const double high_m = box.center.z() + box.half_size.z() - floor_m;
    return IsFurniture(box.label) && high_m > min_high_m && low_m < max_low_m &&
           (inner.half_size.array() > 0).all() && HorizontalDistance(inner, point) == 0;
  });
}

SyntheticWorld QuickWorld(BuildingOptions options, const RouteOptions& route) {
  options.light_map_cell_m = 1.0;
  options.num_light_samples = 1;
  return BuildWorld(options, route, 2);
}

// The grid from the view of a camera that was carried along the robot's route.
GridResult GridOf(const SyntheticWorld& world, const RouteOptions& route, std::size_t step) {
  SyntheticCameraOptions camera;
  const auto poses = PlanRoute(world.layout, route, camera);
  camera.image_width_px = 96;
  camera.image_height_px = 72;
  camera.focal_length_px = 79;
  const Rect2& extent = world.layout.extent;
  const double top_m = world.layout.storey_m * (world.layout.num_floors - 1) + 3;
  Carver carver({extent.x0 - 4, extent.y0 - 1, -0.5}, {extent.x1 + 1, extent.y1 + 4, top_m});
  std::vector<Eigen::Vector3d> cameras_in_map;
  for (std::size_t i = 0; i < poses.size(); i += step) {
    carver.Look(world, poses[i], camera.Pinhole());
    cameras_in_map.push_back(poses[i].translation);
  }
  return ProjectFloors(carver.Tree(), {}, cameras_in_map, 2);
}

// Cells of solid pieces. Under a table the floor may be seen, and a thin top be missed; and what is
// lower than max_hidden_m above a step may be missed too.
int CountFreeInSolids(const SyntheticWorld& world, const FloorGrid& floor) {
  int count = 0;
  for (int y = 0; y < floor.grid.height; ++y) {
    for (int x = 0; x < floor.grid.width; ++x) {
      if (floor.grid.At({x, y}) != kFreeCell) continue;
      const Eigen::Vector2d point = floor.grid.CenterInMap({x, y});
      if (IsInFurniture(world, point, floor.height_m, 0.1, kHidden_m)) {
        ++count;
      }
    }
  }
  return count;
}

Eigen::Vector2d RandomFreePoint(const OccupancyGrid& grid, Random& random) {
  while (true) {
    const Eigen::Vector2i cell(
        static_cast<int>(random.Index(static_cast<std::size_t>(grid.width))),
        static_cast<int>(random.Index(static_cast<std::size_t>(grid.height))));
    if (grid.At(cell) == kFreeCell) return grid.CenterInMap(cell);
  }
}

// Paths between random free cells; returns how many there are.
int CheckPaths(const SyntheticWorld& world, const FloorGrid& floor) {
  constexpr int kNumPairs = 40;
  Random random(3);
  int num_paths = 0;
  for (int i = 0; i < kNumPairs; ++i) {
    PlanOptions options;
    options.footprint.robot_radius_m = 0.1;
    const auto start = RandomFreePoint(floor.grid, random);
    const auto goal = RandomFreePoint(floor.grid, random);
    options.start = fmt::format("{},{}", start.x(), start.y());
    options.goal = fmt::format("{},{}", goal.x(), goal.y());
    Progress progress("plan", false);
    try {
      const PlanResult result = RunPlan(options, {floor.grid, {}, {}}, progress, 2);
      ++num_paths;
      for (const PathPoint& point : result.path) {
        EXPECT_FALSE(IsInFurniture(
            world, point.point_in_map, floor.height_m, GridOptions{}.robot_height_m, 0.15))
            << point.point_in_map.transpose();
      }
    } catch (const DataError&) {
      // The ends are not joined, or the robot does not fit there.
    }
  }
  return num_paths;
}

void CheckBuilding(const BuildingOptions& building, const RouteOptions& route, std::size_t step) {
  const SyntheticWorld world = QuickWorld(building, route);
  const GridResult result = GridOf(world, route, step);
  EXPECT_EQ(result.floors.size(), static_cast<std::size_t>(building.num_floors));
  for (const FloorGrid& floor : result.floors) {
    SCOPED_TRACE(floor.height_m);
    EXPECT_GT(floor.num_free_cells, 3000U);
    EXPECT_EQ(CountFreeInSolids(world, floor), 0);
    EXPECT_GT(CheckPaths(world, floor), 15);
  }
}

TEST(GridOfFurniture, NoPathLeadsOverItInTheDemo) {
  for (const int seed : {1, 3}) {
    SCOPED_TRACE(seed);
    BuildingOptions building;
    building.seed = seed;
    CheckBuilding(building, RouteOptions{}, 3);
  }
}

TEST(GridOfFurniture, NoPathLeadsOverItInMirror) {
  BuildingOptions building;
  building.seed = 7;
  building.num_identical_rooms = 3;
  building.mirrored_corridors = true;
  CheckBuilding(building, RouteOptions{}, 3);
}

TEST(GridOfFurniture, NoPathLeadsOverItOnTwoFloors) {
  CheckBuilding(TwoFloorBuilding(), TwoFloorRoute(), 3);
}

TEST(GridOfFurniture, NoPathLeadsOverItInTheBuilding) {
  if (!IsNight()) GTEST_SKIP() << "takes half a minute: set NIGHTMAP_NIGHTLY=1";
  BuildingOptions building;
  building.num_rooms = 24;
  building.num_identical_rooms = 5;
  building.room_width_m = 4.2;
  building.room_depth_m = 4.0;
  building.corridor_width_m = 1.8;
  RouteOptions route;
  route.num_frames = 3000;
  route.max_step_m = 0.11;
  CheckBuilding(building, route, 8);
}

}  // namespace nightmap::furniture_test
