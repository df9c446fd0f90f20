// SPDX-License-Identifier: Apache-2.0
// Views of the objects of the map in a scan: places that are known not to change.
#pragma once

#include <vector>

#include "pipeline/geometry/rigid2.h"
#include "pipeline/io/grid_io.h"
#include "pipeline/laser/scan_queries_io.h"
#include "pipeline/plan/objects_io.h"

namespace nightmap {

// The centres of the occupied cells within the rectangles.
std::vector<Eigen::Vector2d> WallsOfObjects(const OccupancyGrid& grid,
                                            const std::vector<MapObject>& objects);

// Walls of objects, seen from a pose: a beam ends on those that are confirmed, and passes through
// those that are contradicted, which cannot be. Walls behind what a beam hit, and where no beam
// points or comes back from, say nothing.
struct ObjectView {
  int num_confirmed = 0;
  int num_contradicted = 0;
};
ObjectView ViewObjects(const std::vector<Eigen::Vector2d>& walls_in_map,
                       const ScanQuery& query,
                       const Rigid2& map_from_query,
                       double max_range_m);

// Counts likewise the walls that are in sight, each once: no other wall of the map stands between
// it and the laser whose beam tells of it. A wall that one laser confirms is confirmed.
ObjectView ViewInSight(const OccupancyGrid& grid,
                       const std::vector<Eigen::Vector2d>& walls_in_map,
                       const ScanQuery& query,
                       const Rigid2& map_from_query,
                       double max_range_m);

}  // namespace nightmap
