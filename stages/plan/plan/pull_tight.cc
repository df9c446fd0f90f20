// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/plan/pull_tight.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "stages/plan/plan/segment.h"

namespace nightmap {
namespace {

constexpr double kCostTolerance = 1e-6;  // cells
// Number of successive points that may fail before the search for a longer shortcut ends.
constexpr int kMaxFailures = 32;

constexpr double kGap_cells = 4;    // largest distance between points of the band
constexpr double kMinGain = 1e-4;   // of a move, in cells
constexpr double kFirstStep = 2;    // first move of a point, in cells,
constexpr double kLastStep = 0.25;  // and its last
constexpr std::size_t kReach = 8;   // number of points on either side that move along at first

class ElasticBand {
 public:
  ElasticBand(const CostMap& map, std::vector<Eigen::Vector2d> points)
      : map_(map), points_(std::move(points)) {
    for (std::size_t i = 0; i + 1 < points_.size(); ++i) {
      costs_.push_back(SegmentCost(map_, points_[i], points_[i + 1]));
    }
  }

  void Sweep(std::size_t reach, double step) {
    const std::size_t stride = std::max<std::size_t>(1, reach / 2);
    for (std::size_t first = 0; first + 2 * reach < points_.size(); first += stride) {
      Improve(first, reach, step);
    }
  }

  const std::vector<Eigen::Vector2d>& Points() const { return points_; }

 private:
  // Moves the point `reach` after `first` to one side while the path gets cheaper, otherwise to the
  // other side.
  void Improve(std::size_t first, std::size_t reach, double step) {
    const Eigen::Vector2d along = points_[first + 2 * reach] - points_[first];
    if (along.norm() < 1e-9) return;
    const Eigen::Vector2d side = Eigen::Vector2d(-along.y(), along.x()).normalized() * step;
    const double sign = Move(first, reach, side) ? 1 : -1;
    while (Move(first, reach, sign * side)) continue;
  }

  // Returns whether it moved. Refuses moves that touch a cell that is not free or gain too little.
  bool Move(std::size_t first, std::size_t reach, const Eigen::Vector2d& offset) {
    const std::size_t num_lines = 2 * reach;
    double left = -kMinGain;
    for (std::size_t i = 0; i < num_lines; ++i) left += costs_[first + i];
    moved_[0] = points_[first];
    for (std::size_t i = 0; i < num_lines; ++i) {
      const std::size_t to_end = std::min(i + 1, num_lines - i - 1);
      const double share = static_cast<double>(to_end) / static_cast<double>(reach);
      moved_[i + 1] = points_[first + i + 1] + share * offset;
      moved_costs_[i] = SegmentCost(map_, moved_[i], moved_[i + 1], left);
      left -= moved_costs_[i];
      if (left < 0) return false;
    }
    std::copy_n(moved_.begin(), num_lines, &points_[first]);
    std::copy_n(moved_costs_.begin(), num_lines, &costs_[first]);
    return true;
  }

  const CostMap& map_;
  std::vector<Eigen::Vector2d> points_;
  std::vector<double> costs_;  // of the line from each point to the next
  std::array<Eigen::Vector2d, 2 * kReach + 1> moved_;
  std::array<double, 2 * kReach> moved_costs_ = {};
};

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

std::vector<Eigen::Vector2d> Relax(const CostMap& map, const std::vector<Eigen::Vector2d>& path) {
  ElasticBand band(map, Resample(path, kGap_cells));
  for (double step = kFirstStep; step >= kLastStep; step /= 2) {
    for (std::size_t reach = kReach; reach > 0; reach /= 2) band.Sweep(reach, step);
  }
  return band.Points();
}

std::vector<Eigen::Vector2d> Tighten(const CostMap& map, const std::vector<Eigen::Vector2d>& path) {
  return Resample(Shorten(map, Resample(Relax(map, Shorten(map, path)))));
}

}  // namespace nightmap
