// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_match/scan_shape.h"

#include "pipeline/laser/wall_normals.h"

namespace nightmap {

ScanShape ShapeOf(const ScanMatchOptions& options, const ScanPoints& scan) {
  ScanShape shape;
  auto& points = shape.points;
  for (const Eigen::Vector3d& in_robot : scan.points_in_robot) {
    const Eigen::Vector2d point = in_robot.head<2>();
    if (point.norm() > options.max_range_m) continue;
    if (!points.empty() && (point - points.back()).norm() < options.field.resolution_m) continue;
    points.push_back(point);
  }
  shape.normals = WallNormals(points, options.field.sigma_m / 2);
  return shape;
}

}  // namespace nightmap
