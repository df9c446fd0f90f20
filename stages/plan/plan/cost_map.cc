// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/cost_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "pipeline/base/parallel.h"

namespace nightmap {
namespace {

constexpr double kRounding = 1e-9;  // so that a radius of whole cells fits exactly

// Runs in items of many rows.
void ForRows(int height, int num_threads, const std::function<void(int y)>& body) {
  constexpr int kRowsPerItem = 64;
  const int num_items = (height + kRowsPerItem - 1) / kRowsPerItem;
  ParallelFor(static_cast<std::size_t>(num_items), num_threads, [&](std::size_t item) {
    const int first = static_cast<int>(item) * kRowsPerItem;
    for (int y = first; y < std::min(first + kRowsPerItem, height); ++y) body(y);
  });
}

// Smallest squared distance in cells^2 that is at least the given distance.
int SquaredCells(double distance_m, double resolution_m) {
  const double cells = distance_m / resolution_m;
  return static_cast<int>(std::max(0.0, std::min(std::ceil(cells * cells - kRounding), 2e9)));
}

// Cost of a cell by its squared distance. It falls with the square of the remaining distance, from
// 1 + weight at the radius to 1 from `clearance_m` on; below the margin it is `margin_weight` more.
// The table ends where both do.
std::vector<std::uint16_t> CostTable(const CostOptions& options,
                                     double resolution_m,
                                     double robot_radius_m) {
  const int min_squared = SquaredCells(robot_radius_m, resolution_m);
  const double clearance_m = std::min(options.clearance_m, 4096 * resolution_m);
  const int roomy_squared = SquaredCells(robot_radius_m + options.margin_m, resolution_m);
  const int clear_squared = std::max(roomy_squared, SquaredCells(clearance_m, resolution_m));
  std::vector<std::uint16_t> costs(static_cast<std::size_t>(clear_squared) + 1, CostMap::kUnitCost);
  std::fill_n(costs.begin(), min_squared, std::uint16_t{0});
  for (int i = min_squared; i < clear_squared; ++i) {
    const double distance_m = resolution_m * std::sqrt(static_cast<double>(i));
    const double nearness =
        distance_m < clearance_m ? (clearance_m - distance_m) / (clearance_m - robot_radius_m) : 0;
    const double weight = options.clearance_weight * nearness * nearness +
                          (i < roomy_squared ? options.margin_weight : 0);
    costs[static_cast<std::size_t>(i)] =
        static_cast<std::uint16_t>(std::lround(CostMap::kUnitCost * (1 + weight)));
  }
  return costs;
}

// Effect of a cell's state on its cost.
struct UnknownSpace {
  bool is_free = false;
  std::uint16_t extra_cost = 0;
};

// Obstacles are not free even for a robot of radius 0.
void ApplyStates(const std::uint8_t* states,
                 std::size_t width,
                 UnknownSpace unknown,
                 std::uint16_t* costs) {
  for (std::size_t x = 0; x < width; ++x) {
    const bool is_unknown = states[x] == kUnknownCell;
    const bool is_free = states[x] == kFreeCell || (is_unknown && unknown.is_free);
    const int extra = is_unknown ? unknown.extra_cost : 0;
    costs[x] = static_cast<std::uint16_t>(is_free && costs[x] != 0 ? costs[x] + extra : 0);
  }
}

}  // namespace

CostMap MakeCostMap(const OccupancyGrid& grid,
                    const CostOptions& options,
                    double robot_radius_m,
                    int num_threads) {
  const bool unknown_is_obstacle = options.unknown == "forbidden";
  CostMap map{grid.width, grid.height, grid.resolution_m, robot_radius_m, {}, {}, 0, 0};
  map.distances = ObstacleDistances(grid, unknown_is_obstacle, num_threads);
  const auto table = CostTable(options, grid.resolution_m, robot_radius_m);
  map.roomy_squared = SquaredCells(robot_radius_m + options.margin_m, grid.resolution_m);
  const double margin_weight = options.margin_m > 0 ? options.margin_weight : 0;
  map.margin_cost = static_cast<int>(std::lround(CostMap::kUnitCost * margin_weight));
  const auto last = static_cast<std::uint32_t>(table.size() - 1);
  const double unknown_weight = options.unknown == "costed" ? options.unknown_weight : 0;
  const UnknownSpace unknown = {
      !unknown_is_obstacle,
      static_cast<std::uint16_t>(std::lround(CostMap::kUnitCost * unknown_weight))};
  const auto width = static_cast<std::size_t>(map.width);
  const auto stride = static_cast<std::size_t>(map.Stride());
  map.costs.resize(stride * static_cast<std::size_t>(map.height + 2));
  std::fill_n(map.costs.begin(), stride, std::uint16_t{0});
  std::fill_n(map.costs.end() - map.Stride(), stride, std::uint16_t{0});
  ForRows(map.height, num_threads, [&](int y) {
    std::vector<std::uint32_t> squared;
    map.distances.SquaredOfRow(y, static_cast<std::int32_t>(last), squared);
    const std::uint8_t* states = grid.cells.data() + grid.Index(0, y);
    std::uint16_t* row = map.costs.data() + map.Index({0, y});
    row[-1] = row[width] = 0;
    for (std::size_t x = 0; x < width; ++x) {
      row[x] = table[std::min(squared[x], last)];
    }
    ApplyStates(states, width, unknown, row);
  });
  return map;
}

std::vector<std::int32_t> LabelReachable(const CostMap& map) {
  const std::array<std::ptrdiff_t, 4> sides = {1, -1, map.Stride(), -map.Stride()};
  std::vector<std::int32_t> labels(map.Size(), 0);
  std::vector<std::size_t> open;
  std::int32_t num_labels = 0;
  for (std::size_t seed = 0; seed < map.Size(); ++seed) {
    if (map.costs[seed] == 0 || labels[seed] != 0) continue;
    labels[seed] = ++num_labels;
    open.push_back(seed);
    while (!open.empty()) {
      const std::size_t cell = open.back();
      open.pop_back();
      for (const std::ptrdiff_t side : sides) {
        const std::size_t next = cell + static_cast<std::size_t>(side);
        if (map.costs[next] == 0 || labels[next] != 0) continue;
        labels[next] = num_labels;
        open.push_back(next);
      }
    }
  }
  return labels;
}

}  // namespace nightmap
