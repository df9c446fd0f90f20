// SPDX-License-Identifier: Apache-2.0
// Moves a path to the cheapest places of the cost map around it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "stages/plan/plan/cost_map.h"

namespace nightmap {

// An elastic band (Quinlan and Khatib, Elastic bands: connecting path planning and control, 1993)
// that minimizes the exact cost of its straight lines. Moves points of the path sideways, together
// with the points around them in proportion, over shrinking stretches and by shrinking steps.
// Points are in cells; the centre of cell (x, y) is at (x + 0.5, y + 0.5). The path must be free
// and stays free; its cost never rises, and its first and last point stay. Deterministic.
std::vector<Eigen::Vector2d> Relax(const CostMap& map, const std::vector<Eigen::Vector2d>& path);

}  // namespace nightmap
