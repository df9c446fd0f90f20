// SPDX-License-Identifier: Apache-2.0
// Pulls a path over the cost map tight.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "stages/plan/plan/cost_map.h"

namespace nightmap {

// Replaces stretches of a free path by straight segments wherever these are free and cost no more.
// Points are in cells; the centre of cell (x, y) is at (x + 0.5, y + 0.5). Keeps the first and the
// last point.
std::vector<Eigen::Vector2d> Shorten(const CostMap& map, const std::vector<Eigen::Vector2d>& path);

// The path's points, with points added so that no neighbours are more than `gap_cells` apart.
std::vector<Eigen::Vector2d> Resample(const std::vector<Eigen::Vector2d>& path,
                                      double gap_cells = 1);

// Shortens and relaxes a path (see Relax), then straightens bends that save no cost. Points are at
// most one cell apart.
std::vector<Eigen::Vector2d> Tighten(const CostMap& map, const std::vector<Eigen::Vector2d>& path);

}  // namespace nightmap
