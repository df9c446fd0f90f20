// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/things/upright_box.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

namespace nightmap {
namespace {

constexpr double kStrayShare = 0.01;  // of the points that may lie beyond a side
constexpr double kRadPerDeg = std::numbers::pi / 180;
constexpr double kLayer = 0.95;  // voxels; less than one, so that a layer of the grid is alone
constexpr double kCoarse_deg = 2;
constexpr double kFine_deg = 0.25;

// A place of the footprint, and how many points are above it.
struct FootprintCell {
  Eigen::Vector2d place;
  double weight = 0;
};

// Places are relative to the first, so that angles turn about the thing and not about the map.
std::vector<FootprintCell> FootprintOf(const std::vector<Eigen::Vector3d>& points) {
  std::map<std::pair<double, double>, double> weights;
  for (const Eigen::Vector3d& point : points) ++weights[{point.x(), point.y()}];
  std::vector<FootprintCell> cells;
  for (const auto& [place, weight] : weights) {
    cells.push_back(
        {Eigen::Vector2d(place.first, place.second) - points.front().head<2>(), weight});
  }
  return cells;
}

struct Span {
  double min = 0;
  double max = 0;
};

using Values = std::vector<std::pair<double, double>>;  // and their weights

// The mean of the values behind the strays, up to `layer_m` from the first of them.
template <typename Iterator>
double EndOf(Iterator at, Iterator stop, double stray_weight, double layer_m) {
  while (at->second <= stray_weight) stray_weight -= (at++)->second;
  const double first = at->first;
  double sum = 0, weight = 0;
  for (; at != stop && std::abs(at->first - first) <= layer_m; ++at) {
    sum += at->second * (at->first - first);
    weight += at->second;
  }
  return first + sum / weight;
}

// Where the outer layers of the values are in the mean.
Span SpanOf(Values values, double layer_m) {
  std::ranges::sort(values);
  double sum = 0;
  for (const auto& [value, weight] : values) sum += weight;
  return {EndOf(values.begin(), values.end(), kStrayShare * sum, layer_m),
          EndOf(values.rbegin(), values.rend(), kStrayShare * sum, layer_m)};
}

// A surface across the axis goes through voxels whose centres are so far apart along it.
double LayerAlong(const Eigen::Vector2d& axis, double resolution_m) {
  return kLayer * resolution_m * axis.cwiseAbs().sum();
}

Span SpanAlong(const std::vector<FootprintCell>& cells,
               const Eigen::Vector2d& axis,
               double resolution_m) {
  Values values;
  values.reserve(cells.size());
  for (const FootprintCell& cell : cells) values.emplace_back(axis.dot(cell.place), cell.weight);
  return SpanOf(std::move(values), LayerAlong(axis, resolution_m));
}

double Closeness(const std::vector<FootprintCell>& cells, double heading_rad, double resolution_m) {
  const Eigen::Vector2d x(std::cos(heading_rad), std::sin(heading_rad));
  const Eigen::Vector2d y(-x.y(), x.x());
  const Span along_x = SpanAlong(cells, x, resolution_m);
  const Span along_y = SpanAlong(cells, y, resolution_m);
  const auto to_end_m = [](const Span& span, double value) {
    return std::min(std::abs(value - span.min), std::abs(value - span.max));
  };
  double sum = 0;
  for (const FootprintCell& cell : cells) {
    const double distance_m =
        std::min(to_end_m(along_x, x.dot(cell.place)), to_end_m(along_y, y.dot(cell.place)));
    sum += cell.weight / std::max(distance_m, resolution_m / 2);
  }
  return sum;
}

double HeadingOf(const std::vector<FootprintCell>& cells, double resolution_m) {
  double best_deg = 0, best_closeness = -1;
  const auto search = [&](double from_deg, double to_deg, double step_deg) {
    for (double deg = from_deg; deg < to_deg; deg += step_deg) {
      const double closeness = Closeness(cells, deg * kRadPerDeg, resolution_m);
      if (closeness <= best_closeness) continue;
      best_closeness = closeness;
      best_deg = deg;
    }
  };
  search(0, 90, kCoarse_deg);
  const double coarse_deg = best_deg;
  search(coarse_deg - kCoarse_deg, coarse_deg + kCoarse_deg, kFine_deg);
  return (best_deg < 0 ? best_deg + 90 : best_deg) * kRadPerDeg;
}

}  // namespace

UprightBox FitBox(const std::vector<Eigen::Vector3d>& points_in_map, double resolution_m) {
  const std::vector<FootprintCell> cells = FootprintOf(points_in_map);
  UprightBox box;
  box.map_from_box = {HeadingOf(cells, resolution_m), points_in_map.front().head<2>()};
  const double heading_rad = box.map_from_box.heading_rad;
  const Eigen::Vector2d x(std::cos(heading_rad), std::sin(heading_rad));
  Values heights;
  for (const Eigen::Vector3d& point : points_in_map) heights.emplace_back(point.z(), 1);
  const Span spans[] = {SpanAlong(cells, x, resolution_m),
                        SpanAlong(cells, Eigen::Vector2d(-x.y(), x.x()), resolution_m),
                        SpanOf(std::move(heights), kLayer * resolution_m)};
  for (int axis = 0; axis < 3; ++axis) {
    const double centre = (spans[axis].min + spans[axis].max) / 2;
    const double half = std::max(spans[axis].max - spans[axis].min, resolution_m) / 2;
    box.extent.min()[axis] = centre - half;
    box.extent.max()[axis] = centre + half;
  }
  return box;
}

}  // namespace nightmap
