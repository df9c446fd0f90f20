// SPDX-License-Identifier: Apache-2.0
#include "pipeline/synthetic/synthetic_world.h"

#include "pipeline/synthetic/furnish.h"
#include "pipeline/synthetic/route.h"
#include "pipeline/synthetic/shell.h"

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
  SceneBuilder builder(seed);
  BuildShell(world.layout, options, builder);
  Furnish(world.layout, options, route_points, route.clearance_m, builder);
  world.scene = builder.Finish(num_threads);
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
