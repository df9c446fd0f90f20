// SPDX-License-Identifier: Apache-2.0
// The search for a path over the cost map: Lazy Theta* (Nash, Koenig and Tovey, Lazy Theta*:
// any-angle path planning and path length analysis in 3D, 2010), or without its lines A* (Hart,
// Nilsson and Raphael, A formal basis for the heuristic determination of minimum cost paths, 1968).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "stages/plan/plan/cost_map.h"

namespace nightmap {

enum class Steps { kCellToCell, kAnyAngle };

struct SearchResult {
  bool found = false;
  // From start to goal, both included: each cell of kCellToCell, the turning points of kAnyAngle.
  std::vector<Eigen::Vector2i> cells;
  double cost_cells = 0;         // length in cells, weighted by the map's costs
  std::size_t num_expanded = 0;  // a cell that is expanded again counts again
};

// Both cells must be free. Finds a path exactly when there is one; it stays in free cells and cuts
// no corner. A step to one of the eight neighbours costs its length times the mean cost of its two
// cells. Deterministic.
//
// kCellToCell is A* with the octile distance: no path along the cells is cheaper, and a path and
// its reverse cost exactly the same.
//
// kAnyAngle joins cells by straight lines. It differs from the publication in two ways. A line
// costs its length weighted by the map, so it is drawn only where it costs no more than going from
// cell to cell. And the heuristic is that of BlockField, which knows the walls: only a small part
// of the map is searched, and the path may cost a few per cent more than the cheapest; Tighten
// recovers nearly all of that.
SearchResult FindPath(const CostMap& map,
                      const Eigen::Vector2i& start,
                      const Eigen::Vector2i& goal,
                      Steps steps);

}  // namespace nightmap
