// SPDX-License-Identifier: Apache-2.0
// Finds where a robot can stand for each place it is asked to go to.
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

// Ends that the robot can stand at and that are joined stay where they are asked to be. Else an end
// moves to the centre of a free cell within `snap_radius_m`: of the parts of the map that all ends
// can be in, each at its nearest cell there, the one with the least sum of moves is taken, and one
// that is larger than the robot before any other. (Where there is none each end goes to its nearest
// cell.) Deterministic. Throws DataError when there is
// no free cell within the radius, an end is outside of the map, or two ends one after the other
// are, or become, the same place; the message says why and what to do.
std::vector<Endpoint> PlaceEndpoints(const OccupancyGrid& grid,
                                     const CostMap& map,
                                     const std::vector<EndpointRequest>& requests,
                                     double snap_radius_m);

}  // namespace nightmap
