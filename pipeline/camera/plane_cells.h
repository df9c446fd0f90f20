// SPDX-License-Identifier: Apache-2.0
// Cuts the plane into cells that hold a bounded number of positions.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "pipeline/geometry/rectangle.h"

namespace nightmap {

struct PlaneCell {
  Rectangle box;
  std::size_t num_positions = 0;
};

// Cells that partition the plane; neighbours in the result are neighbours in the plane. Each cell
// with more than `max_positions` is cut at the median along the longer extent of its positions,
// unless that is below `min_extent_m`. The same for any order of the positions. O(n log n).
std::vector<PlaneCell> CutPlane(std::vector<Eigen::Vector2d> positions,
                                std::size_t max_positions,
                                double min_extent_m);

}  // namespace nightmap
