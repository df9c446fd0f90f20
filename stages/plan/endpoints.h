// SPDX-License-Identifier: Apache-2.0
// Turns the options `start` and `goal` into points a robot can stand on.
#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/io/grid_io.h"
#include "pipeline/io/queries_io.h"
#include "stages/plan/cost_map.h"

namespace nightmap {

// What the user asked for.
struct EndpointRequest {
  std::string role;  // "start" or "goal", for messages
  std::string text;  // "x_m,y_m" or "picture:NAME"
  Eigen::Vector2d point_in_map = Eigen::Vector2d::Zero();
  bool may_move = false;  // pictures: a person may stand where the robot cannot
};

// Where the path starts or ends.
struct Endpoint {
  EndpointRequest request;
  Eigen::Vector2d point_in_map = Eigen::Vector2d::Zero();
  Eigen::Vector2i cell = Eigen::Vector2i::Zero();
  double moved_by_m = 0;
};

// Throws UsageError on text of neither form, DataError when the picture is of no use (FindPicture).
EndpointRequest ParseEndpoint(const std::string& role,
                              const std::string& text,
                              const std::vector<QueryResult>& queries);

// Both ends of a path. Pictures in a cell that is not free, or that is cut off from the other end,
// move to the centre of the nearest free cell within `snap_radius_m` such that the ends reach each
// other where that is possible (least sum of both moves). Throws DataError when an end is outside
// of the map, in an obstacle, nearer to one than the robot's radius, or in unknown space; the
// message says where the nearest free cell is.
std::pair<Endpoint, Endpoint> PlaceEndpoints(const OccupancyGrid& grid,
                                             const CostMap& map,
                                             const EndpointRequest& start,
                                             const EndpointRequest& goal,
                                             double snap_radius_m);

}  // namespace nightmap
