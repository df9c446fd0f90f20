// SPDX-License-Identifier: Apache-2.0
// Distances of a grid's cells to obstacles, between the squares of the cells: zero in an obstacle
// and in the cells around it. Exact.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

#include "pipeline/base/uninitialized_vector.h"
#include "pipeline/io/grid_io.h"

namespace nightmap {

// Stores the distances along the columns. A squared distance, in cells^2, is the least sum over the
// columns around a cell (second phase of the distance transform); only columns nearer than the
// nearest obstacle count.
class ObstacleDistances {
 public:
  ObstacleDistances() = default;
  // Cells beyond the grid are unknown. Throws DataError as ColumnDistances does. Deterministic.
  ObstacleDistances(const OccupancyGrid& grid, bool unknown_is_obstacle, int num_threads);

  // Squared distance of one cell, or `cap` if that is smaller. Without any obstacle it is at least
  // width^2.
  std::int32_t Squared(const Eigen::Vector2i& cell,
                       std::int32_t cap = std::numeric_limits<std::int32_t>::max()) const;

  // Squared distances of a row of cells; those not below `cap` may have any value from `cap` on.
  void SquaredOfRow(int y, std::int32_t cap, std::vector<std::uint32_t>& squared) const;

 private:
  const std::uint16_t* Row(int y) const {
    return columns_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
  }

  int width_ = 0;
  bool outside_blocked_ = false;
  UninitializedVector<std::uint16_t> columns_;  // centre to centre
};

}  // namespace nightmap
