// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/grid/distance_maps.h"

#include <cmath>
#include <cstdint>

#include "pipeline/plan/distance_transform.h"

namespace nightmap {
namespace {

// Distance from each cell to the nearest one that `is_target` accepts.
template <typename IsTarget>
std::vector<float> DistanceTo_m(const OccupancyGrid& grid,
                                bool is_outside_target,
                                int num_threads,
                                const IsTarget& is_target) {
  std::vector<std::uint8_t> targets;
  targets.reserve(grid.cells.size());
  for (const std::uint8_t cell : grid.cells) targets.push_back(is_target(cell) ? 1 : 0);
  const auto squared =
      SquaredDistances(targets, grid.width, grid.height, is_outside_target, num_threads);
  std::vector<float> distances_m;
  distances_m.reserve(squared.size());
  for (const std::int32_t cells2 : squared) {
    distances_m.push_back(
        static_cast<float>(grid.resolution_m * std::sqrt(static_cast<double>(cells2))));
  }
  return distances_m;
}

}  // namespace

std::vector<float> Clearance_m(const OccupancyGrid& grid, int num_threads) {
  return DistanceTo_m(grid, true, num_threads, [](std::uint8_t cell) { return cell != kFreeCell; });
}

std::vector<float> SignedDistance_m(const OccupancyGrid& grid, int num_threads) {
  auto distances_m = DistanceTo_m(
      grid, false, num_threads, [](std::uint8_t cell) { return cell == kOccupiedCell; });
  const auto inside_m = DistanceTo_m(
      grid, false, num_threads, [](std::uint8_t cell) { return cell != kOccupiedCell; });
  for (std::size_t i = 0; i < distances_m.size(); ++i) {
    if (grid.cells[i] == kOccupiedCell) distances_m[i] = -inside_m[i];
  }
  return distances_m;
}

}  // namespace nightmap
