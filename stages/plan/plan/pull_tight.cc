// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/pull_tight.h"

#include <algorithm>
#include <cmath>

#include "stages/plan/plan/elastic_band.h"
#include "stages/plan/plan/segment.h"

namespace nightmap {
namespace {

constexpr double kCostTolerance = 1e-6;  // cells
// Number of successive points that may fail before the search for a longer shortcut ends.
constexpr int kMaxFailures = 32;

}  // namespace

std::vector<Eigen::Vector2d> Shorten(const CostMap& map, const std::vector<Eigen::Vector2d>& path) {
  std::vector<Eigen::Vector2d> tight = {path.front()};
  std::size_t anchor = 0;
  while (anchor + 1 < path.size()) {
    std::size_t best = anchor + 1;
    double cost_along = SegmentCost(map, path[anchor], path[best]);
    int num_failures = 0;
    for (std::size_t i = best + 1; i < path.size() && num_failures < kMaxFailures; ++i) {
      cost_along += SegmentCost(map, path[i - 1], path[i]);
      if (SegmentCost(map, path[anchor], path[i]) <= cost_along + kCostTolerance) {
        best = i;
        num_failures = 0;
      } else {
        ++num_failures;
      }
    }
    anchor = best;
    tight.push_back(path[anchor]);
  }
  return tight;
}

std::vector<Eigen::Vector2d> Resample(const std::vector<Eigen::Vector2d>& path, double gap_cells) {
  std::vector<Eigen::Vector2d> points = {path.front()};
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Eigen::Vector2d delta = path[i] - path[i - 1];
    const int num_parts = std::max(1, static_cast<int>(std::ceil(delta.norm() / gap_cells - 1e-9)));
    for (int k = 1; k < num_parts; ++k) {
      points.push_back(path[i - 1] + delta * k / num_parts);
    }
    points.push_back(path[i]);
  }
  return points;
}

std::vector<Eigen::Vector2d> Tighten(const CostMap& map, const std::vector<Eigen::Vector2d>& path) {
  return Resample(Shorten(map, Resample(Relax(map, Shorten(map, path)))));
}

}  // namespace nightmap
