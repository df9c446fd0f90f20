// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/cost_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/distance_transform.h"

namespace nightmap {
namespace {

constexpr double kRounding = 1e-9;  // so that a radius of whole cells is met exactly

// In items of many rows.
void ForRows(int height, int num_threads, const std::function<void(int y)>& body) {
  constexpr int kRowsPerItem = 64;
  const int num_items = (height + kRowsPerItem - 1) / kRowsPerItem;
  ParallelFor(static_cast<std::size_t>(num_items), num_threads, [&](std::size_t item) {
    const int first = static_cast<int>(item) * kRowsPerItem;
    for (int y = first; y < std::min(first + kRowsPerItem, height); ++y) body(y);
  });
}

// The obstacles, each with the eight cells around it: from a cell to the nearest of these, centre
// to centre, is as far as between the squares of the cell and of the obstacle.
std::vector<std::uint8_t> GrownObstacles(const OccupancyGrid& grid,
                                         bool unknown_is_obstacle,
                                         int num_threads) {
  const auto width = static_cast<std::size_t>(grid.width);
  const std::uint8_t rim = unknown_is_obstacle ? 1 : 0;
  std::vector<std::uint8_t> wide(grid.cells.size());  // grown along x
  ForRows(grid.height, num_threads, [&](int y) {
    const std::uint8_t* cells = grid.cells.data() + grid.Index(0, y);
    std::vector<std::uint8_t> row(width + 2, rim);
    for (std::size_t x = 0; x < width; ++x) {
      row[x + 1] = (cells[x] == kOccupiedCell) | ((cells[x] == kUnknownCell) & rim);
    }
    std::uint8_t* out = wide.data() + grid.Index(0, y);
    for (std::size_t x = 0; x < width; ++x) out[x] = row[x] | row[x + 1] | row[x + 2];
  });
  std::vector<std::uint8_t> grown(grid.cells.size());
  const std::vector<std::uint8_t> outside(width, rim);
  ForRows(grid.height, num_threads, [&](int y) {
    const std::uint8_t* own = wide.data() + grid.Index(0, y);
    const std::uint8_t* below = y > 0 ? own - width : outside.data();
    const std::uint8_t* above = y + 1 < grid.height ? own + width : outside.data();
    std::uint8_t* out = grown.data() + grid.Index(0, y);
    for (std::size_t x = 0; x < width; ++x) out[x] = below[x] | own[x] | above[x];
  });
  return grown;
}

// Smallest squared distance in cells^2 that is not nearer than a distance.
int SquaredCells(double distance_m, double resolution_m) {
  const double cells = distance_m / resolution_m;
  return static_cast<int>(std::max(0.0, std::min(std::ceil(cells * cells - kRounding), 2e9)));
}

// Cost of a cell by its squared distance: falls with the square of the remaining distance, from
// 1 + weight at the radius to 1 from `clearance_m` on, where the table ends.
std::vector<std::uint16_t> CostTable(const CostOptions& options,
                                     double resolution_m,
                                     double robot_radius_m) {
  const int min_squared = SquaredCells(robot_radius_m, resolution_m);
  const double clearance_m = std::min(options.clearance_m, 4096 * resolution_m);
  const int clear_squared = std::max(min_squared, SquaredCells(clearance_m, resolution_m));
  std::vector<std::uint16_t> costs(static_cast<std::size_t>(clear_squared) + 1, CostMap::kUnitCost);
  std::fill_n(costs.begin(), min_squared, std::uint16_t{0});
  for (int i = min_squared; i < clear_squared; ++i) {
    const double distance_m = resolution_m * std::sqrt(static_cast<double>(i));
    const double nearness =
        std::clamp((clearance_m - distance_m) / (clearance_m - robot_radius_m), 0.0, 1.0);
    costs[static_cast<std::size_t>(i)] = static_cast<std::uint16_t>(
        std::lround(CostMap::kUnitCost * (1 + options.clearance_weight * nearness * nearness)));
  }
  return costs;
}

}  // namespace

void CostOptions::Register(OptionList& list) {
  list.Add("unknown",
           &unknown,
           {"forbidden", "allowed", "costed"},
           "space that nothing was seen of: an obstacle, free, or free at unknown_weight");
  list.Add("unknown_weight",
           &unknown_weight,
           Range(0.0, 10.0),
           "extra cost of a metre in unknown space when it is costed");
  list.Add("clearance_m",
           &clearance_m,
           Range(0.0, 10.0),
           "obstacles farther away than this do not make a path dearer");
  list.Add("clearance_weight",
           &clearance_weight,
           Range(0.0, 50.0),
           "extra cost of a metre at the robot's radius from an obstacle; 0: shortest path");
}

bool IsObstacle(const OccupancyGrid& grid, const Eigen::Vector2i& cell, bool unknown_is_obstacle) {
  const std::uint8_t value = grid.Contains(cell) ? grid.At(cell) : std::uint8_t{kUnknownCell};
  return value == kOccupiedCell || (value == kUnknownCell && unknown_is_obstacle);
}

CostMap MakeCostMap(const OccupancyGrid& grid,
                    const CostOptions& options,
                    double robot_radius_m,
                    int num_threads) {
  const bool unknown_is_obstacle = options.unknown == "forbidden";
  CostMap map{grid.width, grid.height, grid.resolution_m, robot_radius_m, {}, {}};
  map.squared_distances = SquaredDistances(GrownObstacles(grid, unknown_is_obstacle, num_threads),
                                           grid.width,
                                           grid.height,
                                           unknown_is_obstacle,
                                           num_threads);
  const auto table = CostTable(options, grid.resolution_m, robot_radius_m);
  const auto last = static_cast<std::int32_t>(table.size()) - 1;
  // By state of the cell: obstacles are not free even for a robot without extent.
  const std::array<std::uint16_t, 3> allowed = {
      1, 0, static_cast<std::uint16_t>(!unknown_is_obstacle)};
  const auto unknown_cost = static_cast<std::uint16_t>(
      options.unknown == "costed" ? std::lround(CostMap::kUnitCost * options.unknown_weight) : 0);
  const std::array<std::uint16_t, 3> extra = {0, 0, unknown_cost};
  map.costs.resize(static_cast<std::size_t>(map.Stride()) *
                   static_cast<std::size_t>(map.height + 2));
  ForRows(map.height, num_threads, [&](int y) {
    const std::size_t from = grid.Index(0, y);
    std::uint16_t* row = map.costs.data() + map.Index({0, y});
    for (std::size_t x = 0; x < static_cast<std::size_t>(map.width); ++x) {
      const std::uint8_t state = grid.cells[from + x];
      const std::int32_t squared = std::min(map.squared_distances[from + x], last);
      const int cost = table[static_cast<std::size_t>(squared)] * allowed[state];
      row[x] = static_cast<std::uint16_t>(cost == 0 ? 0 : cost + extra[state]);
    }
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
