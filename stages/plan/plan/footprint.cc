// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/footprint.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "stages/plan/plan/cost_map.h"

namespace nightmap {

void FootprintOptions::Register(OptionList& list) {
  list.Add("robot_radius_m", &robot_radius_m, Range(0.0, 5.0), "radius of a round robot");
  list.Add("footprint_m",
           &footprint_m,
           Range(-5.0, 5.0),
           "corners x0, y0, x1, y1, ... of a polygonal robot, x forward, turning about 0, 0; "
           "overrides robot_radius_m");
}

std::vector<Eigen::Vector2d> FootprintCorners(const FootprintOptions& options) {
  const std::vector<double>& values = options.footprint_m;
  if (values.size() % 2 != 0 || values.size() == 2 || values.size() == 4) {
    throw UsageError(
        "option footprint_m has {} numbers: give x and y of at least three corners, or none",
        values.size());
  }
  std::vector<Eigen::Vector2d> corners;
  for (std::size_t i = 0; i < values.size(); i += 2) corners.emplace_back(values[i], values[i + 1]);
  return corners;
}

double CircumscribedRadius_m(const FootprintOptions& options) {
  const auto corners = FootprintCorners(options);
  if (corners.empty()) return options.robot_radius_m;
  double radius_m = 0;
  for (const Eigen::Vector2d& corner : corners) radius_m = std::max(radius_m, corner.norm());
  return radius_m;
}

bool IsCircleClear(const OccupancyGrid& grid,
                   const Eigen::Vector2d& centre_in_map,
                   double radius_m,
                   bool unknown_is_obstacle) {
  constexpr double kRounding_cells = 1e-6;
  const Eigen::Vector2d centre = grid.ToCells(centre_in_map);
  const double radius = radius_m / grid.resolution_m - kRounding_cells;
  const Eigen::Vector2i own = centre.array().floor().cast<int>();
  if (IsObstacle(grid, own, unknown_is_obstacle)) return false;
  const Eigen::Vector2i first = (centre.array() - std::max(radius, 0.0)).floor().cast<int>();
  const Eigen::Vector2i last = (centre.array() + std::max(radius, 0.0)).floor().cast<int>();
  for (int y = first.y(); y <= last.y(); ++y) {
    for (int x = first.x(); x <= last.x(); ++x) {
      const Eigen::Vector2d corner = Eigen::Vector2d(x, y);
      const Eigen::Vector2d nearest =
          centre.cwiseMax(corner).cwiseMin(corner + Eigen::Vector2d::Ones());
      if ((nearest - centre).norm() < radius && IsObstacle(grid, {x, y}, unknown_is_obstacle)) {
        return false;
      }
    }
  }
  return true;
}

}  // namespace nightmap
