// SPDX-License-Identifier: Apache-2.0
// Pulls a path over the cost map tight.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "stages/plan/cost_map.h"

namespace nightmap {

// Replaces stretches of a free path by straight segments wherever they are free and not dearer.
// Points are in cells, the centre of cell (x, y) at (x + 0.5, y + 0.5). Keeps the first and the
// last point.
std::vector<Eigen::Vector2d> Shorten(const CostMap& map, const std::vector<Eigen::Vector2d>& path);

// Its points, and between them as many that no two are farther than `gap_cells` apart.
std::vector<Eigen::Vector2d> Resample(const std::vector<Eigen::Vector2d>& path,
                                      double gap_cells = 1);

// Shortens and relaxes a path (see Relax), and straightens what that left bent for nothing. Points
// are at most one cell apart.
std::vector<Eigen::Vector2d> Tighten(const CostMap& map, const std::vector<Eigen::Vector2d>& path);

}  // namespace nightmap
