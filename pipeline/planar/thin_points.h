// SPDX-License-Identifier: Apache-2.0
// Fewer points that say the same: many beams on a wall nearby are no better known than one.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace nightmap {

// The first point of each cell of a lattice, in their order.
std::vector<Eigen::Vector2d> ThinPoints(const std::vector<Eigen::Vector2d>& points, double cell_m);

// At most `max_count` of the points, spread evenly over their order.
std::vector<Eigen::Vector2d> SpreadPoints(const std::vector<Eigen::Vector2d>& points,
                                          std::size_t max_count);

}  // namespace nightmap
