// SPDX-License-Identifier: Apache-2.0
#include "pipeline/laser/thin_points.h"

#include <cmath>
#include <cstdint>
#include <set>
#include <utility>

namespace nightmap {
namespace {

template <typename Value>
std::vector<Value> Spread(const std::vector<Value>& values, std::size_t max_count) {
  if (values.size() <= max_count) return values;
  std::vector<Value> spread;
  for (std::size_t i = 0; i < max_count; ++i)
    spread.push_back(values[i * values.size() / max_count]);
  return spread;
}

}  // namespace

std::vector<std::size_t> ThinnedIndices(const std::vector<Eigen::Vector2d>& points, double cell_m) {
  std::set<std::pair<std::int64_t, std::int64_t>> taken;
  std::vector<std::size_t> thinned;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d cell = (points[i] / cell_m).array().floor();
    if (taken.emplace(std::llround(cell.x()), std::llround(cell.y())).second) thinned.push_back(i);
  }
  return thinned;
}

std::vector<Eigen::Vector2d> ThinPoints(const std::vector<Eigen::Vector2d>& points, double cell_m) {
  return PointsAt(points, ThinnedIndices(points, cell_m));
}

std::vector<Eigen::Vector2d> PointsAt(const std::vector<Eigen::Vector2d>& points,
                                      const std::vector<std::size_t>& indices) {
  std::vector<Eigen::Vector2d> found;
  found.reserve(indices.size());
  for (const std::size_t i : indices) found.push_back(points[i]);
  return found;
}

std::vector<Eigen::Vector2d> SpreadPoints(const std::vector<Eigen::Vector2d>& points,
                                          std::size_t max_count) {
  return Spread(points, max_count);
}

std::vector<std::size_t> SpreadIndices(const std::vector<std::size_t>& indices,
                                       std::size_t max_count) {
  return Spread(indices, max_count);
}

}  // namespace nightmap
