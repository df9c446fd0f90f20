// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/mesh/implicit_surface.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace nightmap {
namespace {

int SquareOf(double coordinate_m, double edge_m) {
  return static_cast<int>(std::floor(coordinate_m / edge_m));
}

}  // namespace

ImplicitSurface::ImplicitSurface(std::vector<CloudPoint> points, double square_m)
    : square_m_(square_m), points_(std::move(points)) {
  const auto square = [square_m](const CloudPoint& point) {
    const Eigen::Vector3f& p = point.position_in_map;
    return std::pair(SquareOf(p.x(), square_m), SquareOf(p.y(), square_m));
  };
  std::ranges::sort(points_, {}, [&square](const CloudPoint& point) {
    const Eigen::Vector3f& p = point.position_in_map;
    return std::tuple(square(point), p.z(), p.x(), p.y());
  });
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const auto [x, y] = square(points_[i]);
    if (columns_.empty() || columns_.back().x != x || columns_.back().y != y) {
      columns_.push_back({x, y, i, i});
    }
    ++columns_.back().end;
  }
}

SurfaceSample ImplicitSurface::At(const Eigen::Vector3d& place_in_map, double radius_m) const {
  const double squared_radius_m2 = radius_m * radius_m;
  double sum_of_weights = 0, nearest_m2 = squared_radius_m2, distance_m = 0;
  SurfaceSample sample;
  const auto add = [&](const CloudPoint& point) {
    const Eigen::Vector3d offset = place_in_map - point.position_in_map.cast<double>();
    const double squared_m2 = offset.squaredNorm();
    if (squared_m2 >= squared_radius_m2) return;
    const double root = 1 - squared_m2 / squared_radius_m2;
    const double weight = root * root * root * root;
    const Eigen::Vector3d normal = point.normal_in_map.cast<double>();
    sum_of_weights += weight;
    nearest_m2 = std::min(nearest_m2, squared_m2);
    distance_m += weight * normal.dot(offset);
    sample.normal += weight * normal;
    for (int channel = 0; channel < 3; ++channel) {
      sample.rgb[channel] += weight * point.rgb[static_cast<std::size_t>(channel)];
    }
  };
  const auto square = [&](double coordinate_m) { return SquareOf(coordinate_m, square_m_); };
  const int first_y = square(place_in_map.y() - radius_m);
  const int last_y = square(place_in_map.y() + radius_m);
  const int last_x = square(place_in_map.x() + radius_m);
  const auto before = [](const Column& column, const std::pair<int, int>& key) {
    return std::pair(column.x, column.y) < key;
  };
  for (int x = square(place_in_map.x() - radius_m); x <= last_x; ++x) {
    auto column = std::lower_bound(columns_.begin(), columns_.end(), std::pair(x, first_y), before);
    for (; column != columns_.end() && column->x == x && column->y <= last_y; ++column) {
      const auto end = points_.begin() + static_cast<std::ptrdiff_t>(column->end);
      auto point = std::lower_bound(
          points_.begin() + static_cast<std::ptrdiff_t>(column->begin),
          end,
          place_in_map.z() - radius_m,
          [](const CloudPoint& lower, double z_m) { return lower.position_in_map.z() < z_m; });
      for (; point != end && point->position_in_map.z() < place_in_map.z() + radius_m; ++point) {
        add(*point);
      }
    }
  }
  if (sum_of_weights == 0) return {};
  sample.distance_m = distance_m / sum_of_weights;
  sample.nearest_m = std::sqrt(nearest_m2);
  sample.normal /= sum_of_weights;
  sample.rgb /= sum_of_weights;
  return sample;
}

}  // namespace nightmap
