// SPDX-License-Identifier: Apache-2.0
// Finds where a robot can stand for each place it is asked to go to.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/io/grid_io.h"
#include "stages/plan/cost_map.h"
#include "stages/plan/requests.h"

namespace nightmap {

// Where a leg of the path starts or ends.
struct Endpoint {
  EndpointRequest request;
  Eigen::Vector2d point_in_map = Eigen::Vector2d::Zero();
  Eigen::Vector2i cell = Eigen::Vector2i::Zero();
  double moved_by_m = 0;
};

// An end in a cell that is not free moves to the centre of the nearest free cell within
// `snap_radius_m`, and so does a picture that is cut off from the others, since a person may stand
// where the robot cannot: of the parts of the map that all ends can be in, the one with the least
// sum of moves is taken. (Where there is none each end goes to its nearest cell.) Throws DataError
// when there is no free cell within the radius or an end is outside of the map; the message says
// why and where the nearest free cell is.
std::vector<Endpoint> PlaceEndpoints(const OccupancyGrid& grid,
                                     const CostMap& map,
                                     const std::vector<EndpointRequest>& requests,
                                     double snap_radius_m);

}  // namespace nightmap
