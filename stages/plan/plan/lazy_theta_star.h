// SPDX-License-Identifier: Apache-2.0
// Fast any-angle paths of straight lines: Lazy Theta* (Nash, Koenig and Tovey, Lazy Theta*:
// any-angle path planning and path length analysis in 3D, 2010).
#pragma once

#include <Eigen/Core>

#include "stages/plan/plan/astar.h"
#include "stages/plan/plan/cost_map.h"

namespace nightmap {

// Both cells must be free. Differs from the publication in two ways. A line costs its length
// weighted by the map, so it is drawn only where it costs no more than going from cell to cell. And
// the heuristic is that of BlockField, which knows the walls: only a small part of the map is
// searched, and the path may cost a few per cent more than the cheapest; Tighten recovers nearly
// all of that. Lines stay in free cells. Finds a path exactly when there is one. Deterministic.
SearchResult FindAnyAnglePath(const CostMap& map,
                              const Eigen::Vector2i& start,
                              const Eigen::Vector2i& goal);

}  // namespace nightmap
