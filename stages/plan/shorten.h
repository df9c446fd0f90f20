// SPDX-License-Identifier: Apache-2.0
// Straight lines over the cost map: which cells they touch, and pulling a path of cells tight.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "stages/plan/cost_map.h"

namespace nightmap {

// Points are in cells: the centre of cell (x, y) is (x + 0.5, y + 0.5). Calls visit(cell, length in
// cells) for every cell a segment touches, in order, and stops when visit returns false; both cells
// beside a crossed corner are visited with length 0 (Amanatides and Woo, A fast voxel traversal
// algorithm for ray tracing, 1987). Returns whether visit always returned true.
bool VisitSegment(const Eigen::Vector2d& from,
                  const Eigen::Vector2d& to,
                  const std::function<bool(const Eigen::Vector2i&, double)>& visit);

// Whether a robot can drive straight from one point to the other.
bool IsSegmentFree(const CostMap& map, const Eigen::Vector2d& from, const Eigen::Vector2d& to);

// Replaces stretches of a free path by straight segments wherever they are free and not dearer.
// Keeps the first and the last point.
std::vector<Eigen::Vector2d> Shorten(const CostMap& map, const std::vector<Eigen::Vector2d>& path);

// Points at most one cell apart along the path.
std::vector<Eigen::Vector2d> Resample(const std::vector<Eigen::Vector2d>& path);

}  // namespace nightmap
