// SPDX-License-Identifier: Apache-2.0
// How far the cells of a grid are from obstacles, between the squares of the cells: zero in an
// obstacle and the cells around it. All exact.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

#include "pipeline/base/uninitialized_vector.h"
#include "pipeline/io/grid_io.h"

namespace nightmap {

// Keeps the distances along the columns; a squared distance, in cells^2, is the least sum over the
// columns around a cell (the second phase of the distance transform), of which only those count
// that are nearer than the nearest obstacle.
class ObstacleDistances {
 public:
  ObstacleDistances() = default;
  // Beyond the grid is unknown. Throws DataError as ColumnDistances. Deterministic.
  ObstacleDistances(const OccupancyGrid& grid, bool unknown_is_obstacle, int num_threads);

  // Of one cell, or `cap` if that is smaller. Without any obstacle it is at least width^2.
  std::int32_t Squared(const Eigen::Vector2i& cell,
                       std::int32_t cap = std::numeric_limits<std::int32_t>::max()) const;

  // Of all cells of a row; where they are not below `cap`, some number that is not either.
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
