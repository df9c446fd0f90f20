// SPDX-License-Identifier: Apache-2.0
// Refines a pose on the boundary points that submap and map share (publication CN110307838A, S106).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/geometry/rigid2.h"
#include "stages/laser/scan_localize/scan_map.h"

namespace nightmap {

// Gauss-Newton on the distance of each point in the overlap, which is within gate_m of an occupied
// cell, from the wall there: a line through the occupied cells about the nearest one, or that cell
// where they have no direction. The gate narrows to a few cells. A weak prior about the start holds
// what no wall tells, as along a corridor. Returns map_from_query. Pure.
Rigid2 RefineOnBoundary(const ScanMap& map,
                        const std::vector<Eigen::Vector2d>& points_in_query,
                        const Rigid2& start,
                        double gate_m);

}  // namespace nightmap
