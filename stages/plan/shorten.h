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

// Points at most one cell apart along the path.
std::vector<Eigen::Vector2d> Resample(const std::vector<Eigen::Vector2d>& path);

// Both together, from either end in turn, since what is found depends on the end begun from.
std::vector<Eigen::Vector2d> Tighten(const CostMap& map, std::vector<Eigen::Vector2d> route);

}  // namespace nightmap
