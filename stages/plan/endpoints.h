// SPDX-License-Identifier: Apache-2.0
// Finds a standable place for each requested end of a path.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/io/grid_io.h"
#include "stages/plan/cost_map.h"
#include "stages/plan/parse_ends.h"

namespace nightmap {

// Where a leg of the path starts or ends.
struct Endpoint {
  EndpointRequest request;
  Eigen::Vector2d point_in_map = Eigen::Vector2d::Zero();
  Eigen::Vector2i cell = Eigen::Vector2i::Zero();
  double moved_by_m = 0;
};

// Ends that are standable and connected stay as requested. Otherwise an end moves to the centre of
// a free cell within `snap_radius_m`, of an object within that and half its diagonal. Parts of the
// map that every end can move into are compared by the sum of the moves to each end's nearest cell
// there; the least wins, but parts larger than the robot come first. (Without such a part each end
// moves to its nearest cell.) Deterministic. Throws DataError when there is no free cell within the
// radius, an end is outside the map, or two successive ends are, or become, the same place; the
// message says why and names the remedy.
std::vector<Endpoint> PlaceEndpoints(const OccupancyGrid& grid,
                                     const CostMap& map,
                                     const std::vector<EndpointRequest>& requests,
                                     double snap_radius_m);

}  // namespace nightmap
