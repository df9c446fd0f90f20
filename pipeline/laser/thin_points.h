// SPDX-License-Identifier: Apache-2.0
// Fewer points that say the same: many beams on a wall nearby are no better known than one.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace nightmap {

// Indices of the first point of each cell of a lattice, and these points, in their order.
std::vector<std::size_t> ThinnedIndices(const std::vector<Eigen::Vector2d>& points, double cell_m);
std::vector<Eigen::Vector2d> ThinPoints(const std::vector<Eigen::Vector2d>& points, double cell_m);

// At most `max_count` of the points, or of the indices, spread evenly over their order.
std::vector<Eigen::Vector2d> SpreadPoints(const std::vector<Eigen::Vector2d>& points,
                                          std::size_t max_count);
std::vector<std::size_t> SpreadIndices(const std::vector<std::size_t>& indices,
                                       std::size_t max_count);

// The points of these indices.
std::vector<Eigen::Vector2d> PointsAt(const std::vector<Eigen::Vector2d>& points,
                                      const std::vector<std::size_t>& indices);

}  // namespace nightmap
