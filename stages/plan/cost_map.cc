// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/cost_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/geometry/distance_transform.h"

namespace nightmap {
namespace {

constexpr double kRounding = 1e-9;  // so that a radius of whole cells is met exactly

std::vector<std::uint8_t> Blocked(const OccupancyGrid& grid, bool unknown_is_obstacle) {
  std::vector<std::uint8_t> blocked(grid.cells.size());
  std::transform(grid.cells.begin(), grid.cells.end(), blocked.begin(), [&](std::uint8_t cell) {
    return cell == kOccupiedCell || (cell == kUnknownCell && unknown_is_obstacle) ? 1 : 0;
  });
  return blocked;
}

// Smallest squared distance in cells^2 that is not nearer than a distance.
int SquaredCells(double distance_m, double resolution_m) {
  const double cells = distance_m / resolution_m;
  return std::max(1, static_cast<int>(std::min(std::ceil(cells * cells - kRounding), 2e9)));
}

// Falls with the square of the remaining distance, from 1 + weight at the radius to 1.
std::uint16_t Cost(int squared_distance, double resolution_m, const RobotOptions& options) {
  const double distance_m = resolution_m * std::sqrt(static_cast<double>(squared_distance));
  const double range_m = options.clearance_m - options.robot_radius_m;
  const double nearness = std::clamp((options.clearance_m - distance_m) / range_m, 0.0, 1.0);
  const double cost = 1 + options.clearance_weight * nearness * nearness;
  return static_cast<std::uint16_t>(std::lround(CostMap::kUnitCost * cost));
}

}  // namespace

double CostMap::Clearance_m(const Eigen::Vector2i& cell) const {
  return resolution_m * std::sqrt(static_cast<double>(squared_distances[Index(cell)]));
}

CostMap MakeCostMap(const OccupancyGrid& grid, const RobotOptions& options, int num_threads) {
  CostMap map{grid.width, grid.height, grid.resolution_m, {}, {}};
  map.squared_distances = SquaredDistances(Blocked(grid, options.unknown_is_obstacle),
                                           grid.width,
                                           grid.height,
                                           options.unknown_is_obstacle,
                                           num_threads);
  const int min_squared = SquaredCells(options.robot_radius_m, grid.resolution_m);
  const int clear_squared = std::max(
      min_squared,
      SquaredCells(std::min(options.clearance_m, 4096 * grid.resolution_m), grid.resolution_m));
  std::vector<std::uint16_t> costs(static_cast<std::size_t>(clear_squared) + 1, CostMap::kUnitCost);
  for (int i = 0; i < clear_squared; ++i) {
    costs[static_cast<std::size_t>(i)] =
        i < min_squared ? std::uint16_t{0} : Cost(i, grid.resolution_m, options);
  }
  map.costs.resize(map.squared_distances.size());
  std::transform(map.squared_distances.begin(),
                 map.squared_distances.end(),
                 map.costs.begin(),
                 [&](std::int32_t squared) {
                   return costs[static_cast<std::size_t>(std::min(squared, clear_squared))];
                 });
  return map;
}

std::vector<std::int32_t> LabelReachable(const CostMap& map) {
  constexpr std::array<std::array<int, 2>, 4> kSides = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
  std::vector<std::int32_t> labels(map.Size(), 0);
  std::vector<std::size_t> open;
  std::int32_t num_labels = 0;
  for (std::size_t seed = 0; seed < map.Size(); ++seed) {
    if (map.costs[seed] == 0 || labels[seed] != 0) continue;
    labels[seed] = ++num_labels;
    open.push_back(seed);
    while (!open.empty()) {
      const Eigen::Vector2i cell = map.Cell(open.back());
      open.pop_back();
      for (const auto& side : kSides) {
        const Eigen::Vector2i next = cell + Eigen::Vector2i(side[0], side[1]);
        if (!map.IsFree(next) || labels[map.Index(next)] != 0) continue;
        labels[map.Index(next)] = num_labels;
        open.push_back(map.Index(next));
      }
    }
  }
  return labels;
}

}  // namespace nightmap
