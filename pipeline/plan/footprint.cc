// SPDX-License-Identifier: Apache-2.0
#include "pipeline/plan/footprint.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"

namespace nightmap {

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

}  // namespace nightmap
