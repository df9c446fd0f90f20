// SPDX-License-Identifier: Apache-2.0
// The cells that a straight line crosses: Amanatides, Woo, "A Fast Voxel Traversal Algorithm for
// Ray Tracing" (Eurographics 1987), in two dimensions.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace nightmap {

// Calls visit(cell) for each cell from that of `from` to that of `to`, both included, in the order
// of the line. Points are in units of cells and finite; their cells fit into an int. Consecutive
// cells share an edge. Through a corner the walk steps in x first.
template <typename Visit>
void WalkCells(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const Visit& visit) {
  Eigen::Vector2i cell = from.array().floor().cast<int>();
  const Eigen::Vector2i last = to.array().floor().cast<int>();
  const Eigen::Vector2d way = to - from;
  Eigen::Vector2i step, num_left;  // steps per axis: counting them ends the walk in `last` exactly
  Eigen::Vector2d next, period;    // fraction of the line at the next border; from border to border
  for (int axis = 0; axis < 2; ++axis) {
    step[axis] = last[axis] > cell[axis] ? 1 : -1;
    num_left[axis] = std::abs(last[axis] - cell[axis]);
    if (num_left[axis] == 0) continue;
    const double border = cell[axis] + (step[axis] > 0 ? 1 : 0);
    next[axis] = (border - from[axis]) / way[axis];
    period[axis] = 1 / std::abs(way[axis]);
  }
  visit(cell);
  while (num_left.x() + num_left.y() > 0) {
    const bool in_x = num_left.y() == 0 || (num_left.x() > 0 && next.x() <= next.y());
    const int axis = in_x ? 0 : 1;
    cell[axis] += step[axis];
    next[axis] += period[axis];
    --num_left[axis];
    visit(cell);
  }
}

}  // namespace nightmap
