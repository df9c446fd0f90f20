// SPDX-License-Identifier: Apache-2.0
// Moves a path to where the cost map is cheapest around it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "stages/plan/cost_map.h"

namespace nightmap {

// An elastic band (Quinlan and Khatib, Elastic bands: connecting path planning and control, 1993)
// that minimizes the exact cost of its straight lines: points of the path are moved sideways, the
// ones around them along in proportion, over stretches and by steps that become smaller. Points are
// in cells, the centre of cell (x, y) at (x + 0.5, y + 0.5). The path must be free and stays so; it
// becomes no dearer, and its first and last point stay. Deterministic.
std::vector<Eigen::Vector2d> Relax(const CostMap& map, const std::vector<Eigen::Vector2d>& path);

}  // namespace nightmap
