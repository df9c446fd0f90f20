// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/drive/check_path.h"

#include "pipeline/base/input_error.h"
#include "pipeline/plan/floors_io.h"

namespace nightmap {
namespace {

constexpr double kRounding_m = 2e-6;  // of a path file's points

bool IsOnGrid(const OccupancyGrid& grid, const Eigen::Vector2d& point_in_map) {
  const Eigen::Array2d point = grid.ToCells(point_in_map).array();
  const Eigen::Array2d size(grid.width, grid.height);
  const double rounding = kRounding_m / grid.resolution_m;
  return (point >= -rounding).all() && (point <= size + rounding).all();
}

[[noreturn]] void Fail(const OccupancyGrid& grid, const Eigen::Vector2d& point, std::size_t line) {
  throw InputError(
      {{"csv"}},
      InputError::Remedy::kInText,
      "line {}: the path is not on this grid: the point {:.3f},{:.3f} is outside of the map, which "
      "spans {}; run make plan again",
      line,
      point.x(),
      point.y(),
      SpanText(grid));
}

}  // namespace

void CheckOnGrid(const PlannedPath& path, const OccupancyGrid& grid) {
  std::size_t line = 2;  // after the header
  for (std::size_t leg_idx = 0; leg_idx < path.legs_in_map.size(); ++leg_idx) {
    const auto& leg = path.legs_in_map[leg_idx];
    // A later leg begins with the last point of the previous one, which the file has only once.
    for (std::size_t i = leg_idx == 0 ? 0 : 1; i < leg.size(); ++i, ++line) {
      if (!IsOnGrid(grid, leg[i])) Fail(grid, leg[i], line);
    }
  }
}

}  // namespace nightmap
