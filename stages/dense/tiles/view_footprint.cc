// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/tiles/view_footprint.h"

#include <algorithm>

namespace nightmap {
namespace {

struct Interval {
  double min = Rectangle::kUnbounded;
  double max = -Rectangle::kUnbounded;
  void Add(double value) {
    min = std::min(min, value);
    max = std::max(max, value);
  }
};

// Whether a line perpendicular to `axis` separates the points from the rectangle.
bool Separates(const Eigen::Vector2d& axis,
               const ViewFootprint& footprint,
               const Rectangle& rectangle) {
  Interval points, corners;
  for (const Eigen::Vector2d& point : footprint) points.Add(axis.dot(point));
  for (const double x : {rectangle.min_m.x(), rectangle.max_m.x()}) {
    for (const double y : {rectangle.min_m.y(), rectangle.max_m.y()}) {
      corners.Add(axis.dot(Eigen::Vector2d(x, y)));
    }
  }
  return points.max < corners.min || corners.max < points.min;
}

}  // namespace

ViewPyramid MakeViewPyramid(const Camera& camera, double max_depth_m) {
  Interval x, y;
  const auto add = [&](int column, int row) {
    const Eigen::Vector2d ray = camera.Normalize(Eigen::Vector2d(column, row));
    x.Add(ray.x());
    y.Add(ray.y());
  };
  for (int column = 0; column < camera.width; ++column) {
    add(column, 0);
    add(column, camera.height - 1);
  }
  for (int row = 0; row < camera.height; ++row) {
    add(0, row);
    add(camera.width - 1, row);
  }
  return {Eigen::Vector3d::Zero(),
          Eigen::Vector3d(x.min, y.min, 1) * max_depth_m,
          Eigen::Vector3d(x.max, y.min, 1) * max_depth_m,
          Eigen::Vector3d(x.min, y.max, 1) * max_depth_m,
          Eigen::Vector3d(x.max, y.max, 1) * max_depth_m};
}

ViewFootprint ProjectToMap(const ViewPyramid& pyramid, const Rigid3& map_from_camera) {
  ViewFootprint footprint;
  for (std::size_t i = 0; i < pyramid.size(); ++i) {
    footprint[i] = (map_from_camera * pyramid[i]).head<2>();
  }
  return footprint;
}

bool Touches(const ViewFootprint& footprint, const Rectangle& rectangle) {
  if (Separates(Eigen::Vector2d::UnitX(), footprint, rectangle)) return false;
  if (Separates(Eigen::Vector2d::UnitY(), footprint, rectangle)) return false;
  // The hull's edges are among the lines through two points; testing the other lines does no harm.
  for (std::size_t i = 0; i < footprint.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Eigen::Vector2d edge = footprint[i] - footprint[j];
      if (Separates({-edge.y(), edge.x()}, footprint, rectangle)) return false;
    }
  }
  return true;
}

}  // namespace nightmap
