// SPDX-License-Identifier: Apache-2.0
// The signed distance from the surface on which points with normals lie.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <vector>

#include "pipeline/dense/ply_io.h"

namespace nightmap {

struct SurfaceSample {
  // Positive on the seen side. NaN and the values below as they are here: no point is near.
  double distance_m = std::numeric_limits<double>::quiet_NaN();
  double nearest_m = std::numeric_limits<double>::infinity();  // distance of the nearest point
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();            // mean, not of unit length
  Eigen::Vector3d rgb = Eigen::Vector3d::Zero();
};

class ImplicitSurface {
 public:
  // Looks points up by squares of the map of that edge.
  ImplicitSurface(std::vector<CloudPoint> points, double square_m);

  // Weighted means over the points within a radius of a place, by (1 - d^2 / radius^2)^4. The order
  // of the sum depends on nothing but these points. May be called on several threads.
  SurfaceSample At(const Eigen::Vector3d& place_in_map, double radius_m) const;

 private:
  // Points above one another, from the lowest, in a square of the map.
  struct Column {
    int x = 0;
    int y = 0;
    std::size_t begin = 0;
    std::size_t end = 0;
  };

  double square_m_;
  std::vector<CloudPoint> points_;
  std::vector<Column> columns_;
};

}  // namespace nightmap
