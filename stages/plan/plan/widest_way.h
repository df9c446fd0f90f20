// SPDX-License-Identifier: Apache-2.0
// The way between two cells that leaves the most room, and where it is too narrow.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "stages/plan/plan/cost_map.h"

namespace nightmap {

struct Bottleneck {
  Eigen::Vector2i cell = Eigen::Vector2i::Zero();  // the narrowest of the place
  double clearance_m = 0;  // the largest radius of a robot that passes, see CostMap
};

// Finds the way of 4-connected cells without obstacles from one cell to the other whose narrowest
// cell is the widest (Pollack, The maximum capacity through a network, 1960) and which has the
// fewest cells that are too narrow for the map's robot; returns the places of such cells in order.
// There are none when the way is wide enough, when no way joins the two cells, or when one of them
// is an obstacle. Deterministic.
std::vector<Bottleneck> FindBottlenecks(const CostMap& map,
                                        const Eigen::Vector2i& from,
                                        const Eigen::Vector2i& to);

}  // namespace nightmap
