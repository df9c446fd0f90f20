// SPDX-License-Identifier: Apache-2.0
// Cheapest path on the cost map from cell to neighbouring cell by A* (Hart, Nilsson and Raphael, A
// formal basis for the heuristic determination of minimum cost paths, 1968).
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "stages/plan/plan/cost_map.h"

namespace nightmap {

// A step costs its length times the mean cost of its two cells. Costs are integers so that a path
// and its reverse cost exactly the same.
struct SearchCost {
  static constexpr std::int64_t kStraight = 65536;  // length of one cell
  static constexpr std::int64_t kDiagonal = 92682;  // sqrt(2) * kStraight

  // Cost of one metre (or one cell) in free space far from obstacles is 1.
  static double InCells(std::int64_t cost) {
    return static_cast<double>(cost) / static_cast<double>(kStraight * 2 * CostMap::kUnitCost);
  }
  // Least possible cost between two cells: octile distance.
  static std::int64_t LowerBound(const Eigen::Vector2i& a, const Eigen::Vector2i& b);
};

struct SearchResult {
  bool found = false;
  // From start to goal, both included: each cell of A*, or the turning points of FindAnyAnglePath.
  std::vector<Eigen::Vector2i> cells;
  double cost_cells = 0;         // length in cells, weighted by the map's costs
  std::size_t num_expanded = 0;  // a cell that is expanded again counts again
};

// Both cells must be free. 8-connected; a diagonal step needs both cells beside it free. F = G + H
// with the octile distance as H. No path is cheaper. Deterministic.
SearchResult FindPath(const CostMap& map,
                      const Eigen::Vector2i& start,
                      const Eigen::Vector2i& goal);

}  // namespace nightmap
