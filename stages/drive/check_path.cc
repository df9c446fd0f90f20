// SPDX-License-Identifier: Apache-2.0
#include "stages/drive/check_path.h"

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

constexpr double kFileRounding_m = 2e-6;

bool IsOnGrid(const OccupancyGrid& grid, const Eigen::Vector2d& point_in_map) {
  const Eigen::Vector2d cells = grid.ToCells(point_in_map);
  const double rounding = kFileRounding_m / grid.resolution_m;
  // Written so that NaN is not on the grid.
  return cells.x() >= -rounding && cells.y() >= -rounding && cells.x() <= grid.width + rounding &&
         cells.y() <= grid.height + rounding;
}

[[noreturn]] void Fail(const PlannedPath& path,
                       const OccupancyGrid& grid,
                       std::size_t point_number,
                       const Eigen::Vector2d& point) {
  const Eigen::Vector2d low = grid.FromCells({0, 0});
  const Eigen::Vector2d high = grid.FromCells(Eigen::Vector2d(grid.width, grid.height));
  throw DataError(
      "{}: point {} at {:.3f},{:.3f}: the path is not on this grid, which spans {:.3f},{:.3f} to "
      "{:.3f},{:.3f}: run make plan again, or give the grid that the path was planned on",
      path.file.string(),
      point_number,
      point.x(),
      point.y(),
      low.x(),
      low.y(),
      high.x(),
      high.y());
}

}  // namespace

void CheckOnGrid(const PlannedPath& path, const OccupancyGrid& grid) {
  std::size_t point_number = 0;
  for (std::size_t leg = 0; leg < path.legs_in_map.size(); ++leg) {
    // A leg begins with the last point of the one before it, which the file has once.
    for (std::size_t i = leg > 0 ? 1 : 0; i < path.legs_in_map[leg].size(); ++i) {
      const Eigen::Vector2d& point = path.legs_in_map[leg][i];
      if (!IsOnGrid(grid, point)) Fail(path, grid, point_number + 1, point);
      ++point_number;
    }
  }
}

}  // namespace nightmap
