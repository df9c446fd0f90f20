// SPDX-License-Identifier: Apache-2.0
// Finds a standable place for each requested end of a path.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/io/grid_io.h"
#include "stages/plan/plan/cost_map.h"
#include "stages/plan/plan/parse_ends.h"

namespace nightmap {

// Where an end is of a thing that it is beside; the earlier the better. From a hidden place an
// obstacle, as a wall, is before the thing.
enum class ThingSide { kFront, kOther, kHidden };

// Where a leg of the path starts or ends.
struct Endpoint {
  EndpointRequest request;
  Eigen::Vector2d point_in_map = Eigen::Vector2d::Zero();
  Eigen::Vector2i cell = Eigen::Vector2i::Zero();
  double moved_by_m = 0;
  ThingSide side = ThingSide::kFront;  // of a box that has a front
};

// Ends that are standable and connected stay as requested. Otherwise an end moves to the centre of
// the nearest free cell within `snap_radius_m`, of a box within that of its rectangle; up to 15 cm
// farther for a cell with the margin's room. A box with a
// front is never stood in: the robot's circle keeps clear of it, and ThingSide decides before the
// distance. Parts of the map that every end can move into are compared by the sum of the
// moves of ends that are no boxes, then by how well boxes are reached (ThingSide), then by the
// moves to boxes; the least wins, but parts larger than the robot come first. (Without such a part
// each end moves to its nearest cell.) Among several choices the one with the shortest way from the
// end before it is taken, a hidden place only when all are. Deterministic. Throws DataError when
// there is no free cell within the radius, an end is outside the map, or two successive ends are,
// or become, the same place; the message says why and names the remedy.
std::vector<Endpoint> PlaceEndpoints(const OccupancyGrid& grid,
                                     const CostMap& map,
                                     const std::vector<EndChoices>& choices,
                                     double snap_radius_m);

// The reach of snap_radius_m: the distance of a point from a box, or else from the requested point.
double DistanceFrom_m(const EndpointRequest& request, const Eigen::Vector2d& point_in_map);

}  // namespace nightmap
