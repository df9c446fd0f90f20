// SPDX-License-Identifier: Apache-2.0
// Poses for query pictures: beside the route, in free space, with a view that the route saw.
#pragma once

#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "pipeline/world/synthetic_world.h"

namespace nightmap {

struct SyntheticQuery {
  Rigid3 building_from_camera;
  int frame_idx = 0;           // frame of the route that it was derived from
  double offset_m = 0;         // horizontal distance to the nearest frame of the route
  double covisible_ratio = 0;  // share of its view that nearby frames of the route saw
};

// Query i comes from the i-th part of the route if a pose is found there, else from anywhere.
// Throws UsageError naming the options to relax when no pose is found at all.
std::vector<SyntheticQuery> PlanQueries(const SyntheticWorld& world,
                                        const std::vector<Rigid3>& route,
                                        const SyntheticCameraOptions& camera,
                                        const DepthSensorOptions& sensor,
                                        const QueryOptions& options,
                                        int seed,
                                        int num_threads = 1);

}  // namespace nightmap
