// SPDX-License-Identifier: Apache-2.0
// The upright box around voxels.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "pipeline/geometry/rigid2.h"

namespace nightmap {

struct UprightBox {
  Rigid2 map_from_box;  // the origin of the box's frame may be anywhere, its axes are the box's
  Eigen::AlignedBox3d extent;  // in the box's frame; z is the map's

  Eigen::Vector3d ToMap(const Eigen::Vector3d& point_in_box) const {
    Eigen::Vector3d point = point_in_box;
    point.head<2>() = map_from_box * Eigen::Vector2d(point_in_box.head<2>());
    return point;
  }
  Eigen::Vector2d Centre() const {
    return map_from_box * Eigen::Vector2d(extent.center().head<2>());
  }
};

// Points are centres of voxels in the map frame, at least one. The heading is in [0, pi/2): that of
// the rectangle whose sides most points are near to, each by 1 / distance (the closeness criterion
// of Zhang, Xu, Dong, Dolan, "Efficient L-Shape Fitting for Vehicle Detection Using Laser
// Scanners", IV 2017). So it follows two faces alone as well as a top. Each side goes through the
// mean of the outermost layer of voxels, because a surface goes through the middle of its voxels in
// the mean; 1 % of the points may lie beyond it as strays. Each size is a voxel at least.
UprightBox FitBox(const std::vector<Eigen::Vector3d>& points_in_map, double resolution_m);

}  // namespace nightmap
