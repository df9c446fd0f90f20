// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/floor_plan.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace nightmap {

namespace {

constexpr double kTouch_m = 1e-6;  // sharing a border is no overlap

// Separating axis test of a rotated rectangle and a square cell.
bool Overlaps(const Box& box, const Eigen::Vector2d& cell_center, double half_cell_m) {
  const double c = std::cos(box.yaw_rad);
  const double s = std::sin(box.yaw_rad);
  const Eigen::Vector2d offset = cell_center - box.center.head<2>();
  const double reach_x = std::abs(c) * box.half_size.x() + std::abs(s) * box.half_size.y();
  const double reach_y = std::abs(s) * box.half_size.x() + std::abs(c) * box.half_size.y();
  const double cell_reach = half_cell_m * (std::abs(c) + std::abs(s));
  return std::abs(offset.x()) < reach_x + half_cell_m - kTouch_m &&
         std::abs(offset.y()) < reach_y + half_cell_m - kTouch_m &&
         std::abs(c * offset.x() + s * offset.y()) < box.half_size.x() + cell_reach - kTouch_m &&
         std::abs(c * offset.y() - s * offset.x()) < box.half_size.y() + cell_reach - kTouch_m;
}

void DrawBox(const Box& box, OccupancyGrid& grid) {
  const double reach = box.half_size.head<2>().norm();
  const Eigen::Vector2d center = box.center.head<2>();
  const Eigen::Vector2i low = grid.CellOf(center - Eigen::Vector2d(reach, reach)).cwiseMax(0);
  const Eigen::Vector2i high = grid.CellOf(center + Eigen::Vector2d(reach, reach));
  for (int y = low.y(); y <= std::min(high.y(), grid.height - 1); ++y) {
    for (int x = low.x(); x <= std::min(high.x(), grid.width - 1); ++x) {
      if (Overlaps(box, grid.CenterInMap({x, y}), grid.resolution_m / 2)) {
        grid.cells[grid.Index(x, y)] = kOccupiedCell;
      }
    }
  }
}

// Height of the ramp where it belongs to a floor.
std::optional<double> RampOfFloor_m(const FloorLayout& layout,
                                    const Eigen::Vector2d& point,
                                    int floor,
                                    double step_m) {
  if (!layout.ramp_hall) return {};
  const auto ramp_m = layout.ramp_hall->RampHeight_m(point.x(), point.y());
  if (!ramp_m) return {};
  const bool is_of_floor = floor == 0 ? *ramp_m < layout.storey_m - step_m : *ramp_m > step_m;
  return is_of_floor ? ramp_m : std::nullopt;
}

CellValue StateWithoutBoxes(const FloorLayout& layout,
                            const Eigen::Vector2d& point,
                            int floor,
                            double step_m) {
  if (layout.IsIndoors(point.x(), point.y())) return kFreeCell;
  if (!layout.ramp_hall) return kUnknownCell;
  const RampHall& hall = *layout.ramp_hall;
  if (hall.landing.Contains(point.x(), point.y())) return kFreeCell;
  if (RampOfFloor_m(layout, point, floor, step_m)) return kFreeCell;
  const bool is_edge = floor > 0 && hall.RampHeight_m(point.x(), point.y());
  return is_edge ? kOccupiedCell : kUnknownCell;
}

// Whether a box is an obstacle above the ground of a floor.
bool IsInBand(const Box& box,
              const FloorLayout& layout,
              const FloorPlanOptions& options,
              int floor) {
  const double ground_m = RampOfFloor_m(layout, box.center.head<2>(), floor, options.min_height_m)
                              .value_or(floor * layout.storey_m);
  return box.center.z() - box.half_size.z() < ground_m + options.max_height_m &&
         box.center.z() + box.half_size.z() > ground_m + options.min_height_m;
}

}  // namespace

OccupancyGrid TrueFloorPlan(const SyntheticWorld& world,
                            const FloorPlanOptions& options,
                            int floor) {
  Rect2 extent = world.layout.extent;
  if (const auto& hall = world.layout.ramp_hall) {
    const double wall_m = extent.x1 - world.layout.corridor[1].x1;
    extent.x0 = hall->landing.x0 - wall_m;
    extent.y1 = std::max(extent.y1, hall->half_landing.y1 + wall_m);
  }
  // The border lies on whole cells, so that plans of one building always have the same raster.
  const auto to_cell = [&](double value) {
    return static_cast<int>(std::floor(value / options.cell_m + 1e-9));
  };
  OccupancyGrid grid;
  grid.resolution_m = options.cell_m;
  const Eigen::Vector2i low(to_cell(extent.x0) - 4, to_cell(extent.y0) - 4);
  grid.origin_in_map = options.cell_m * low.cast<double>();
  grid.width = to_cell(extent.x1) + 5 - low.x();
  grid.height = to_cell(extent.y1) + 5 - low.y();
  grid.cells.assign(grid.Index(0, grid.height), kUnknownCell);
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      grid.cells[grid.Index(x, y)] =
          StateWithoutBoxes(world.layout, grid.CenterInMap({x, y}), floor, options.min_height_m);
    }
  }
  for (const Box& box : world.scene.boxes) {
    if (IsInBand(box, world.layout, options, floor)) DrawBox(box, grid);
  }
  return grid;
}

}  // namespace nightmap
