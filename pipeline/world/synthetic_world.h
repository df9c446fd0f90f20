// SPDX-License-Identifier: Apache-2.0
// The whole synthetic building, ready to be rendered. Also the scene of other stages' tests:
//
//   const SyntheticWorld world = BuildWorld(BuildingOptions{}, RouteOptions{});
//   const std::vector<Rigid3> poses = PlanRoute(world.layout, RouteOptions{}, camera_options);
//   const RenderedFrame frame = Render(world, camera, poses[0], DepthSensorOptions{}, 2.0, 0);
#pragma once

#include <memory>
#include <vector>

#include "pipeline/world/floor_layout.h"
#include "pipeline/world/light_map.h"
#include "pipeline/world/ray_scene.h"
#include "pipeline/world/scene.h"
#include "pipeline/world/synthetic_options.h"

namespace nightmap {

// Building frame: z up, floor at z = 0, metres. Immutable and safe to share between threads.
struct SyntheticWorld {
  FloorLayout layout;
  Scene scene;
  std::shared_ptr<const RayScene> rays;
  LightMap light;
};

// Builds and furnishes the building around the route. Depends only on the options.
SyntheticWorld BuildWorld(const BuildingOptions& options,
                          const RouteOptions& route,
                          int num_threads = 1);

// A world of given surfaces under even light, for tests.
SyntheticWorld WorldOfScene(Scene scene);

}  // namespace nightmap
