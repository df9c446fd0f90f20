// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/drive/clearance_map.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/plan/distance_transform.h"
#include "pipeline/plan/unknown_holes.h"

namespace nightmap {
namespace {

constexpr double kRounding = 1e-3;  // cells, of the distances as floats
constexpr double kFileRounding_m = 2e-6;

Eigen::Vector2d CenterOf(const Eigen::Vector2i& cell) {
  return cell.cast<double>() + Eigen::Vector2d(0.5, 0.5);
}

}  // namespace

ClearanceMap::ClearanceMap(const OccupancyGrid& grid, const Footprint& footprint)
    : grid_(WithHolesFree(grid, footprint.max_hole_m)),
      footprint_(footprint),
      min_clearance_m_(footprint.radius_m - kFileRounding_m) {
  std::vector<std::uint8_t> blocked;
  blocked.reserve(grid.cells.size());
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) blocked.push_back(IsObstacle({x, y}) ? 1 : 0);
  }
  const auto squared =
      SquaredDistances(blocked, grid.width, grid.height, footprint.unknown_is_obstacle, 1);
  distances_.reserve(squared.size());
  for (const std::int32_t cells2 : squared) {
    distances_.push_back(std::sqrt(static_cast<float>(cells2)));
  }
}

bool ClearanceMap::IsObstacle(const Eigen::Vector2i& cell) const {
  const int value = grid_.Contains(cell) ? grid_.At(cell) : static_cast<int>(kUnknownCell);
  return value == kOccupiedCell || (value == kUnknownCell && footprint_.unknown_is_obstacle);
}

std::pair<double, double> ClearanceMap::Bounds(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d last(grid_.width - 1, grid_.height - 1);
  const Eigen::Vector2i cell =
      point.array().floor().max(0).min(last.array()).cast<int>();  // nearest cell in the grid
  const double distance = distances_[grid_.Index(cell.x(), cell.y())];
  const double off = (point - CenterOf(cell)).norm() + kRounding;
  return {distance - off - 0.5 * std::numbers::sqrt2, distance + off};
}

double ClearanceMap::Clearance_m(const Eigen::Vector2d& point_in_map) const {
  const Eigen::Vector2d point = grid_.ToCells(point_in_map);
  const auto [low, high] = Bounds(point);
  const double far = kFar_m / grid_.resolution_m;
  if (low >= far) return low * grid_.resolution_m;
  const double reach = std::min(high, far);
  const Eigen::Vector2i first = (point.array() - reach).floor().cast<int>();
  const Eigen::Vector2i last = (point.array() + reach).floor().cast<int>();
  double squared = far * far;
  for (int y = first.y(); y <= last.y(); ++y) {
    for (int x = first.x(); x <= last.x(); ++x) {
      if (!IsObstacle({x, y})) continue;
      const Eigen::Array2d beside = (point - CenterOf({x, y})).array().abs() - 0.5;
      squared = std::min(squared, beside.max(0).matrix().squaredNorm());
    }
  }
  return grid_.resolution_m * std::sqrt(squared);
}

bool ClearanceMap::IsClear(const Eigen::Vector2d& point_in_map, double margin_m) const {
  const double least_m = min_clearance_m_ + margin_m;
  const double low_m = Bounds(grid_.ToCells(point_in_map)).first * grid_.resolution_m;
  return low_m >= least_m || Clearance_m(point_in_map) >= least_m;
}

}  // namespace nightmap
