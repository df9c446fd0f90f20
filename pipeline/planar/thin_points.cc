// SPDX-License-Identifier: Apache-2.0
#include "pipeline/planar/thin_points.h"

#include <cmath>
#include <cstdint>
#include <set>
#include <utility>

namespace nightmap {

std::vector<Eigen::Vector2d> ThinPoints(const std::vector<Eigen::Vector2d>& points, double cell_m) {
  std::set<std::pair<std::int64_t, std::int64_t>> taken;
  std::vector<Eigen::Vector2d> thinned;
  for (const Eigen::Vector2d& point : points) {
    const Eigen::Vector2d cell = (point / cell_m).array().floor();
    if (taken.emplace(std::llround(cell.x()), std::llround(cell.y())).second) {
      thinned.push_back(point);
    }
  }
  return thinned;
}

std::vector<Eigen::Vector2d> SpreadPoints(const std::vector<Eigen::Vector2d>& points,
                                          std::size_t max_count) {
  if (points.size() <= max_count) return points;
  std::vector<Eigen::Vector2d> spread;
  for (std::size_t i = 0; i < max_count; ++i)
    spread.push_back(points[i * points.size() / max_count]);
  return spread;
}

}  // namespace nightmap
