// SPDX-License-Identifier: Apache-2.0
// Cheap paths of straight lines in any direction: Lazy Theta* (Nash, Koenig and Tovey, Lazy Theta*:
// any-angle path planning and path length analysis in 3D, 2010).
#pragma once

#include <Eigen/Core>

#include "stages/plan/astar.h"
#include "stages/plan/cost_map.h"

namespace nightmap {

// Both cells must be free. Differs from the publication in that a line costs its length weighted by
// the map, so that it is drawn only where it is not dearer than going from cell to cell; and in
// that the estimate of the cost to the goal is that of BlockField, which knows the walls: a small
// part of the map is searched, and the path may be a few per cent dearer than the cheapest, nearly
// all of which Tighten makes good. Lines keep to free cells. Finds a path exactly when there is
// one. Deterministic.
SearchResult FindAnyAnglePath(const CostMap& map,
                              const Eigen::Vector2i& start,
                              const Eigen::Vector2i& goal);

}  // namespace nightmap
