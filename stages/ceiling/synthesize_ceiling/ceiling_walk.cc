// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/synthesize_ceiling/ceiling_walk.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace nightmap {

namespace {

constexpr double kTouching_m = 1e-9;
constexpr int kMaxSteps = 100;  // rectangles that a ray crosses

// The coordinate of a side, and the interval of the other coordinate.
struct SideLine {
  double at_m = 0, begin_m = 0, end_m = 0;
};

SideLine SideOf(const Rect2& area, int side) {
  if (side == 0) return {area.x0, area.y0, area.y1};
  if (side == 1) return {area.x1, area.y0, area.y1};
  if (side == 2) return {area.y0, area.x0, area.x1};
  return {area.y1, area.x0, area.x1};
}

}  // namespace

CeilingWalk::CeilingWalk(const CeilingPlan& plan) {
  for (const CeilingRect& rect : plan.rects) cells_.push_back({rect.area, rect.height_m, {}});
  for (Cell& cell : cells_) {
    for (int side = 0; side < 4; ++side) {
      const SideLine own = SideOf(cell.area, side);
      for (std::size_t i = 0; i < cells_.size(); ++i) {
        const SideLine other = SideOf(cells_[i].area, side ^ 1);
        const double begin_m = std::max(own.begin_m, other.begin_m);
        const double end_m = std::min(own.end_m, other.end_m);
        if (std::abs(own.at_m - other.at_m) > kTouching_m || end_m <= begin_m) continue;
        cell.neighbours[static_cast<std::size_t>(side)].push_back(
            {static_cast<int>(i), begin_m, end_m});
      }
    }
  }
}

int CeilingWalk::NeighbourAt(const Cell& cell, int side, double along_m, double height_m) const {
  for (const Neighbour& neighbour : cell.neighbours[static_cast<std::size_t>(side)]) {
    if (along_m < neighbour.begin_m || along_m >= neighbour.end_m) continue;
    if (height_m >= cells_[static_cast<std::size_t>(neighbour.rect)].height_m) return -1;
    return neighbour.rect;
  }
  return -1;
}

CeilingHit CeilingWalk::Cast(int rect,
                             const Eigen::Vector3d& origin,
                             const Eigen::Vector3d& direction) const {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  if (rect < 0 || direction.z() <= 0) return {};
  const double per_z = 1 / direction.z();
  const double slope_x = direction.x() * per_z;  // per metre of height
  const double slope_y = direction.y() * per_z;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Cell& cell = cells_[static_cast<std::size_t>(rect)];
    const Rect2& area = cell.area;
    const double rise_m = cell.height_m - origin.z();
    const double x = origin.x() + rise_m * slope_x;
    const double y = origin.y() + rise_m * slope_y;
    if (x >= area.x0 && x <= area.x1 && y >= area.y0 && y <= area.y1) {
      return {rect, kCeilingFace, rise_m * per_z, {x - area.x0, y - area.y0}};
    }
    const int side_x = slope_x > 0 ? 1 : 0;
    const int side_y = slope_y > 0 ? 3 : 2;
    const double to_x =
        slope_x == 0 ? kNever : ((side_x == 1 ? area.x1 : area.x0) - origin.x()) / slope_x;
    const double to_y =
        slope_y == 0 ? kNever : ((side_y == 3 ? area.y1 : area.y0) - origin.y()) / slope_y;
    const bool is_x = to_x < to_y;
    const int side = is_x ? side_x : side_y;
    const double side_rise_m = std::max(0.0, is_x ? to_x : to_y);
    const double height_m = origin.z() + side_rise_m;
    const double along_m =
        is_x ? origin.y() + side_rise_m * slope_y : origin.x() + side_rise_m * slope_x;
    const int next = NeighbourAt(cell, side, along_m, height_m);
    if (next < 0) {
      return {rect, side, side_rise_m * per_z, {along_m - (is_x ? area.y0 : area.x0), height_m}};
    }
    rect = next;
  }
  return {};
}

}  // namespace nightmap
