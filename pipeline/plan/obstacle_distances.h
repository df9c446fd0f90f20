// SPDX-License-Identifier: Apache-2.0
// How far obstacles are, and with that whether a round robot fits: the one answer of planning and
// driving. The whole square of an obstacle's cell counts, because the thing seen in it may be
// anywhere in it. Exact.
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
  // Files round to micrometres, so a path at exactly the robot's radius would not fit without it.
  static constexpr double kFileRounding_m = 2e-6;

  ObstacleDistances() = default;
  // Cells beyond the grid are unknown. Throws DataError as ColumnDistances does. Deterministic.
  ObstacleDistances(const OccupancyGrid& grid, bool unknown_is_obstacle, int num_threads);

  // Whether a robot must not touch the cell.
  bool IsObstacle(const Eigen::Vector2i& cell) const {
    const bool is_on_grid =
        cell.x() >= 0 && cell.y() >= 0 && cell.x() < width_ && cell.y() < height_;
    return is_on_grid ? Row(cell.y())[cell.x()] == 0 : outside_blocked_;
  }

  // Distance of a point, in cells, to the nearest obstacle, or `cap_m` if that is smaller; 0 in an
  // obstacle.
  double Clearance_m(const Eigen::Vector2d& point, double cap_m = 100) const;

  // Whether a round robot at a point, in cells, touches no obstacle. One without extent is in none.
  bool Fits(const Eigen::Vector2d& point, double radius_m) const;

  // The squared distance between the square of one cell and the nearest obstacle, in cells^2: 0 in
  // an obstacle and in the cells around it, or `cap` if that is smaller. Without any obstacle it is
  // at least width^2.
  std::int32_t Squared(const Eigen::Vector2i& cell,
                       std::int32_t cap = std::numeric_limits<std::int32_t>::max()) const;

  // Squared distances of a row of cells; those not below `cap` may have any value from `cap` on.
  void SquaredOfRow(int y, std::int32_t cap, std::vector<std::uint32_t>& squared) const;

 private:
  const std::uint16_t* Row(int y) const {
    return columns_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
  }

  int width_ = 0;
  int height_ = 0;
  double resolution_m_ = 0;
  bool outside_blocked_ = false;
  UninitializedVector<std::uint16_t> columns_;  // centre to centre
};

}  // namespace nightmap
