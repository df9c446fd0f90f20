// SPDX-License-Identifier: Apache-2.0
// The grids of a whole building with two floors, seen from exact poses, against its exact plans.
#include "tests/world/two_floors.h"

#include <gtest/gtest.h>

#include "pipeline/world/floor_plan.h"
#include "tests/stages/dense/grid/carver.h"
#include "tests/stages/dense/grid/room.h"

namespace nightmap::two_floors_test {

struct Agreement {
  int num_seen = 0;
  int num_right = 0;
  int num_plan_free = 0;
  int num_found_free = 0;
};

// A seen cell is right when the plan has its state within one cell.
Agreement Compare(const OccupancyGrid& grid, const OccupancyGrid& plan) {
  Agreement agreement;
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const int state = grid.At({x, y});
      if (state == kUnknownCell) continue;
      const Eigen::Vector2i cell = plan.CellOf(grid.CenterInMap({x, y}));
      bool is_right = false;
      for (int i = 0; i < 9; ++i) {
        const Eigen::Vector2i near = cell + Eigen::Vector2i(i % 3 - 1, i / 3 - 1);
        is_right |= plan.Contains(near) && plan.At(near) == state;
      }
      ++agreement.num_seen;
      agreement.num_right += is_right ? 1 : 0;
    }
  }
  for (int y = 0; y < plan.height; ++y) {
    for (int x = 0; x < plan.width; ++x) {
      if (plan.At({x, y}) != kFreeCell) continue;
      const Eigen::Vector2i cell = grid.CellOf(plan.CenterInMap({x, y}));
      ++agreement.num_plan_free;
      agreement.num_found_free += grid.Contains(cell) && grid.At(cell) == kFreeCell ? 1 : 0;
    }
  }
  return agreement;
}

TEST(GridOfTwoFloors, EachFloorHasItsOwnRightGrid) {
  const SyntheticWorld& world = TwoFloorWorld();
  SyntheticCameraOptions camera;
  camera.image_width_px = 96;
  camera.image_height_px = 72;
  camera.focal_length_px = 79;
  Carver carver({-3.5, -0.5, -0.5}, {6.5, 13.5, 6});
  std::vector<Eigen::Vector3d> cameras_in_map;
  const std::vector<Rigid3> poses = TwoFloorPoses();
  for (std::size_t i = 0; i < poses.size(); i += 3) {
    carver.Look(world, poses[i], camera.Pinhole());
    cameras_in_map.push_back(poses[i].translation);
  }
  const GridResult result = ProjectFloors(carver.Tree(), {}, cameras_in_map, 2);
  ASSERT_EQ(result.floors.size(), 2U);
  EXPECT_EQ(result.main_floor_idx, 0U);
  EXPECT_NEAR(result.floors[1].height_m, world.layout.storey_m, 0.03);
  for (int floor = 0; floor < 2; ++floor) {
    const auto& grid = result.floors[static_cast<std::size_t>(floor)].grid;
    const Agreement agreement = Compare(grid, TrueFloorPlan(world, FloorPlanOptions{}, floor));
    EXPECT_GT(agreement.num_seen, 10000) << floor;
    EXPECT_GE(agreement.num_right, 0.97 * agreement.num_seen) << floor;
    EXPECT_GE(agreement.num_found_free, 0.7 * agreement.num_plan_free) << floor;
  }
}

}  // namespace nightmap::two_floors_test
