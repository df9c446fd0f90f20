// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/synthetic_world.h"

#include "pipeline/world/furnish.h"
#include "pipeline/world/route.h"
#include "pipeline/world/shell.h"

namespace nightmap {

SyntheticWorld BuildWorld(const BuildingOptions& options,
                          const RouteOptions& route,
                          int num_threads) {
  const auto seed = static_cast<std::uint64_t>(options.seed);
  SyntheticWorld world;
  world.layout = PlanLayout(options);
  std::vector<Eigen::Vector2d> route_points;
  for (const RoutePoint& point : PlanPath(world.layout, route))
    route_points.push_back(point.position);
  for (int floor = 0; floor < options.num_floors; ++floor) {
    BuildingOptions storey = options;
    storey.seed += floor;  // the same rooms with different furniture
    SceneBuilder builder(static_cast<std::uint64_t>(storey.seed));
    BuildShell(world.layout, storey, builder);
    Furnish(world.layout, storey, route_points, route.clearance_m, builder);
    AddScene(builder.Finish(num_threads), floor * world.layout.storey_m, world.scene);
  }
  if (world.layout.ramp_hall) {
    SceneBuilder builder(seed);
    BuildRampHall(*world.layout.ramp_hall, options, world.layout.corridor[3], builder);
    AddScene(builder.Finish(num_threads), 0, world.scene);
  }
  world.rays = std::make_shared<RayScene>(world.scene.surfaces);
  world.light = LightMap(world.scene,
                         *world.rays,
                         options.light_map_cell_m,
                         options.num_light_samples,
                         seed,
                         num_threads);
  return world;
}

SyntheticWorld WorldOfScene(Scene scene) {
  SyntheticWorld world;
  world.scene = std::move(scene);
  world.rays = std::make_shared<RayScene>(world.scene.surfaces);
  world.light = LightMap(world.scene, *world.rays, 10.0, 1, 0, 1);
  return world;
}

}  // namespace nightmap
