// SPDX-License-Identifier: Apache-2.0
// A small building with two floors and the route through it, for tests.
#pragma once

#include "pipeline/world/route.h"
#include "pipeline/world/synthetic_world.h"

namespace nightmap {

inline BuildingOptions TwoFloorBuilding() {
  BuildingOptions options;
  options.num_floors = 2;
  options.num_rooms = 1;
  options.light_map_cell_m = 1.0;
  options.num_light_samples = 1;
  return options;
}

inline RouteOptions TwoFloorRoute() {
  RouteOptions options;
  options.num_frames = 950;
  return options;
}

// Built once for all tests of a program.
inline const SyntheticWorld& TwoFloorWorld() {
  static const SyntheticWorld world = BuildWorld(TwoFloorBuilding(), TwoFloorRoute(), 2);
  return world;
}

inline std::vector<Rigid3> TwoFloorPoses() {
  return PlanRoute(TwoFloorWorld().layout, TwoFloorRoute(), SyntheticCameraOptions{});
}

}  // namespace nightmap
