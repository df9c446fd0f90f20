// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/no_path.h"

#include <fmt/format.h>

#include <algorithm>

#include "pipeline/base/error.h"
#include "stages/plan/plan/widest_way.h"

namespace nightmap {
namespace {

// The part of the map that an end reaches.
struct Reach {
  std::size_t num_cells = 0;
  Eigen::Vector2i nearest;  // cell that is nearest to the other end
};

Reach ReachOf(const OccupancyGrid& grid,
              const CostMap& map,
              const std::vector<std::int32_t>& labels,
              const Endpoint& end,
              const Endpoint& other) {
  const auto distance_m = [&](const Eigen::Vector2i& cell) {
    const Eigen::Vector2d point = grid.CenterInMap(cell);
    return other.request.box ? other.request.box->Distance_m(point)
                             : (point - other.point_in_map).norm();
  };
  const std::int32_t label = labels[map.Index(end.cell)];
  Reach reach{0, end.cell};
  double least_m = distance_m(end.cell);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (labels[i] != label) continue;
    ++reach.num_cells;
    const double cell_m = distance_m(map.Cell(i));
    if (cell_m >= least_m) continue;
    least_m = cell_m;
    reach.nearest = map.Cell(i);
  }
  return reach;
}

std::string WhoPasses(const OccupancyGrid& grid,
                      const CostMap& map,
                      const CostOptions& options,
                      const Endpoint& start,
                      const Endpoint& goal) {
  const bool is_forbidden = options.unknown == "forbidden";
  const auto places = FindBottlenecks(map, start.cell, goal.cell);
  if (places.empty()) {
    return fmt::format("obstacles{} part them", is_forbidden ? " and unseen space" : "");
  }
  const auto narrowest = std::ranges::min_element(places, {}, &Bottleneck::clearance_m);
  const Eigen::Vector2d point = grid.CenterInMap(narrowest->cell);
  return fmt::format(
      "the widest way between them, for a robot of radius {:.3f}, is narrowest at "
      "{:.3f},{:.3f}",
      narrowest->clearance_m,
      point.x(),
      point.y());
}

}  // namespace

void FailUnreachable(const OccupancyGrid& grid,
                     const CostMap& map,
                     const CostOptions& options,
                     const Endpoint& start,
                     const Endpoint& goal) {
  const auto labels = LabelReachable(map);
  const Reach of_start = ReachOf(grid, map, labels, start, goal);
  const Reach of_goal = ReachOf(grid, map, labels, goal, start);
  const Eigen::Vector2d point = grid.CenterInMap(of_start.nearest);
  const double cell_m2 = grid.resolution_m * grid.resolution_m;
  throw DataError(
      "no path from {} to {}: the first reaches {:.2f} m2, at its nearest {:.3f},{:.3f}, "
      "{:.2f} m from the other, which reaches {:.2f} m2, and no part of the map is within "
      "snap_radius_m of all ends; {}; try a smaller robot, a larger snap_radius_m or unknown = "
      "\"costed\"",
      EndText(start.request),
      EndText(goal.request),
      cell_m2 * static_cast<double>(of_start.num_cells),
      point.x(),
      point.y(),
      goal.request.box ? goal.request.box->Distance_m(point) : (point - goal.point_in_map).norm(),
      cell_m2 * static_cast<double>(of_goal.num_cells),
      WhoPasses(grid, map, options, start, goal));
}

}  // namespace nightmap
