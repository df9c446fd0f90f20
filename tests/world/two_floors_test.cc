// SPDX-License-Identifier: Apache-2.0
#include "tests/world/two_floors.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/world/floor_plan.h"

namespace nightmap::two_floors_test {

TEST(TwoFloors, TheCameraIsAtItsHeightAboveTheGroundAllAlong) {
  const SyntheticWorld& world = TwoFloorWorld();
  const SyntheticCameraOptions camera;
  double highest_m = 0;
  for (const Rigid3& pose : TwoFloorPoses()) {
    const RayHit hit = world.rays->Cast(pose.translation, -Eigen::Vector3d::UnitZ());
    ASSERT_GE(hit.surface_idx, 0);
    const auto& surface = world.scene.surfaces[static_cast<std::size_t>(hit.surface_idx)];
    EXPECT_EQ(surface.label, SurfaceLabel::kFloor);
    EXPECT_NEAR(hit.distance, camera.camera_height_m, 0.04) << pose.translation.transpose();
    highest_m = std::max(highest_m, pose.translation.z());
  }
  EXPECT_NEAR(highest_m, world.layout.storey_m + camera.camera_height_m, 0.02);
}

TEST(TwoFloors, TheRouteIsClosedAndKeepsItsDistanceAndItsLimits) {
  const std::vector<Rigid3> route = TwoFloorPoses();
  const RouteOptions options = TwoFloorRoute();
  double to_start_m = 1e9;
  for (std::size_t i = 0; i < route.size(); ++i) {
    const Eigen::Vector3d& at = route[i].translation;
    const double ground_m = at.z() - SyntheticCameraOptions{}.camera_height_m;
    EXPECT_GE(Clearance(TwoFloorWorld().scene.boxes, at.head<2>(), ground_m + 0.1, ground_m + 1.5),
              0.3)
        << at.transpose();
    if (i + 30 > route.size()) {
      to_start_m = std::min(to_start_m, (at - route.front().translation).norm());
    }
    if (i == 0) continue;
    const Eigen::Vector3d step = at - route[i - 1].translation;
    EXPECT_LE(step.head<2>().norm(), options.max_step_m + 2e-3);
    EXPECT_LE(AngleBetween_rad(route[i], route[i - 1]), options.max_turn_rad + 5e-3);
  }
  EXPECT_LT(to_start_m, 0.12);
}

// Level rays at the camera's height from all along the route: the plan of the floor that the ground
// belongs to is free here, and occupied where they end unless they end on the ramp or its ceiling.
TEST(TwoFloors, ThePlansAgreeWithRays) {
  const SyntheticWorld& world = TwoFloorWorld();
  const OccupancyGrid plans[] = {TrueFloorPlan(world, FloorPlanOptions{}, 0),
                                 TrueFloorPlan(world, FloorPlanOptions{}, 1)};
  const std::vector<Rigid3> route = TwoFloorPoses();
  int num_checked[] = {0, 0};
  for (std::size_t i = 0; i < route.size(); i += 5) {
    const Eigen::Vector3d& at = route[i].translation;
    const int floor = at.z() > 1.0 + world.layout.storey_m / 2 ? 1 : 0;
    const OccupancyGrid& plan = plans[floor];
    EXPECT_EQ(plan.At(plan.CellOf(at.head<2>())), kFreeCell) << at.transpose();
    if (world.layout.ramp_hall->RampHeight_m(at.x(), at.y())) continue;
    for (int k = 0; k < 24; ++k) {
      const double angle_rad = k * 0.2618 + 0.01;
      const Eigen::Vector3d direction(std::cos(angle_rad), std::sin(angle_rad), 0);
      const RayHit hit = world.rays->Cast(at, direction);
      ASSERT_GE(hit.surface_idx, 0);
      const auto& surface = world.scene.surfaces[static_cast<std::size_t>(hit.surface_idx)];
      const Eigen::Vector3d normal = surface.Normal();
      const double side = normal.dot(direction) > 0 ? 0.004 : -0.004;
      const Eigen::Vector2d inside = (at + hit.distance * direction + side * normal).head<2>();
      if (surface.label == SurfaceLabel::kFloor) continue;
      if (world.layout.ramp_hall->RampHeight_m(inside.x(), inside.y())) continue;
      EXPECT_EQ(plan.At(plan.CellOf(inside)), kOccupiedCell) << inside.transpose();
      ++num_checked[floor];
    }
  }
  EXPECT_GT(num_checked[0], 1000);
  EXPECT_GT(num_checked[1], 1000);
}

TEST(TwoFloors, BothFloorsHaveTheRampAndOneHasItsEdge) {
  const SyntheticWorld& world = TwoFloorWorld();
  const RampHall& hall = *world.layout.ramp_hall;
  const auto state = [&](int floor, double x, double y) {
    const OccupancyGrid plan = TrueFloorPlan(world, FloorPlanOptions{}, floor);
    return plan.At(plan.CellOf({x, y}));
  };
  const double west_x = (hall.up.x0 + hall.up.x1) / 2;
  const double east_x = (hall.down.x0 + hall.down.x1) / 2;
  const double middle_y = (hall.up.y0 + hall.up.y1) / 2;
  for (int floor = 0; floor < 2; ++floor) {
    EXPECT_EQ(state(floor, west_x, middle_y), kFreeCell);
    EXPECT_EQ(state(floor, east_x, middle_y), kFreeCell);
    EXPECT_EQ(state(floor, hall.up.x1 + 0.05, middle_y), kOccupiedCell);  // between the lanes
  }
  EXPECT_EQ(state(0, west_x, hall.up.y0 + 0.2), kFreeCell);
  EXPECT_EQ(state(1, west_x, hall.up.y0 + 0.2), kOccupiedCell);
  EXPECT_EQ(state(1, east_x, hall.down.y0 + 0.2), kFreeCell);
  EXPECT_EQ(state(0, east_x, hall.down.y0 + 0.2), kUnknownCell);
}

TEST(TwoFloors, FloorsAreFurnishedDifferently) {
  const OccupancyGrid lower = TrueFloorPlan(TwoFloorWorld(), FloorPlanOptions{}, 0);
  const OccupancyGrid upper = TrueFloorPlan(TwoFloorWorld(), FloorPlanOptions{}, 1);
  ASSERT_EQ(lower.cells.size(), upper.cells.size());
  int num_different = 0;
  for (std::size_t i = 0; i < lower.cells.size(); ++i) {
    num_different += lower.cells[i] != upper.cells[i] ? 1 : 0;
  }
  EXPECT_GT(num_different, 500);
}

}  // namespace nightmap::two_floors_test
