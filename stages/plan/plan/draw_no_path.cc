// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>
#include <set>

#include "pipeline/base/error.h"
#include "pipeline/plan/draw_on_grid.h"
#include "pipeline/plan/unknown_holes.h"
#include "stages/plan/plan/colors.h"
#include "stages/plan/plan/no_path.h"
#include "stages/plan/plan/path_output.h"
#include "stages/plan/plan/widest_way.h"

namespace nightmap {
namespace {

constexpr Rgb kStartReach = {190, 230, 195};
constexpr Rgb kGoalReach = {245, 200, 195};
constexpr Rgb kOtherReach = {205, 220, 245};
constexpr Rgb kNarrowest = {200, 90, 0};

// The free space for the robot, cut into parts that reach each other.
struct FreeSpace {
  CostMap map;
  std::vector<std::int32_t> labels;
  std::map<std::int32_t, std::vector<Eigen::Vector2d>> parts;  // centres of cells, by label
};

FreeSpace MakeFreeSpace(const PlanOptions& options, const OccupancyGrid& grid, int num_threads) {
  FreeSpace space;
  const double radius_m = CircumscribedRadius_m(options.footprint);
  space.map = MakeCostMap(grid, options.cost, radius_m, num_threads);
  space.labels = LabelReachable(space.map);
  for (std::size_t i = 0; i < space.labels.size(); ++i) {
    if (space.labels[i] == 0) continue;
    space.parts[space.labels[i]].push_back(grid.CenterInMap(space.map.Cell(i)));
  }
  return space;
}

// The parts that an end may be moved to.
std::set<std::int32_t> PartsFrom(const FreeSpace& space,
                                 const EndChoices& choices,
                                 const OccupancyGrid& grid,
                                 double snap_radius_m) {
  std::set<std::int32_t> parts;
  for (const EndpointRequest& request : choices) {
    const Eigen::Vector2i own = grid.CellOf(request.point_in_map);
    if (space.map.IsFree(own)) parts.insert(space.labels[space.map.Index(own)]);
    for (const auto& [label, centres] : space.parts) {
      if (std::ranges::any_of(centres, [&](const Eigen::Vector2d& centre) {
            return DistanceFrom_m(request, centre) <= snap_radius_m;
          })) {
        parts.insert(label);
      }
    }
  }
  return parts;
}

// An end outside of the map is drawn at its border.
void DrawOutside(GridCanvas& canvas,
                 const OccupancyGrid& grid,
                 const EndpointRequest& request,
                 const Rgb& color) {
  const Eigen::Array2d size(grid.width, grid.height);
  const Eigen::Array2d cells = grid.ToCells(request.point_in_map).array();
  const Eigen::Vector2d border = grid.FromCells(cells.max(0).min(size).matrix());
  canvas.Ring(border, 6, color);
  canvas.Label(border, 8, 8, request.role + " is outside", color);
}

void DrawRequest(GridCanvas& canvas,
                 const OccupancyGrid& grid,
                 const EndpointRequest& request,
                 double snap_radius_m,
                 const Rgb& color) {
  const int radius_px = std::max(4, canvas.Picture().width / 200);
  if (!grid.Contains(grid.CellOf(request.point_in_map))) {
    DrawOutside(canvas, grid, request, color);
    return;
  }
  if (request.box) canvas.Rectangle(request.box->map_from_box, request.box->size_m, color);
  if (!request.box && snap_radius_m > 0) {
    canvas.Ring(request.point_in_map, canvas.ToPixels(snap_radius_m), color);
  }
  canvas.Disc(request.point_in_map, radius_px, color);
  canvas.Label(request.point_in_map, radius_px + 3, radius_px + 2, request.role, color);
}

// The places where legs are stopped. None when an end has no place where the robot can stand.
std::vector<Eigen::Vector2d> Bottlenecks(const PlanOptions& options,
                                         const OccupancyGrid& grid,
                                         const FreeSpace& space,
                                         const std::vector<EndChoices>& requests) {
  std::vector<Endpoint> ends;
  try {
    ends = PlaceEndpoints(grid, space.map, requests, options.snap_radius_m);
  } catch (const DataError&) {
    return {};
  }
  std::vector<Eigen::Vector2d> narrowest;
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    const auto label = [&](std::size_t k) { return space.labels[space.map.Index(ends[k].cell)]; };
    if (label(i) == label(i + 1)) continue;
    for (const Bottleneck& place : FindBottlenecks(space.map, ends[i].cell, ends[i + 1].cell)) {
      narrowest.push_back(grid.CenterInMap(place.cell));
    }
  }
  return narrowest;
}

}  // namespace

ColorImage DrawNoPath(const PlanOptions& options, const PlanInputs& inputs, int num_threads) {
  const auto requests = RequestsOnFloor(options, inputs);
  const OccupancyGrid grid = WithHolesFree(inputs.grid, options.cost.max_hole_m);
  const FreeSpace space = MakeFreeSpace(options, grid, num_threads);
  GridCanvas canvas(inputs.grid, PixelsPerCell(inputs.grid), true);
  const double tint_px = 0.71 * canvas.ToPixels(grid.resolution_m);
  std::map<std::int32_t, Rgb> colors;
  for (const auto& [label, centres] : space.parts) colors[label] = kOtherReach;
  for (std::size_t i = requests.size(); i-- > 0;) {
    for (const std::int32_t label : PartsFrom(space, requests[i], grid, options.snap_radius_m)) {
      colors[label] = i == 0 ? kStartReach : kGoalReach;
    }
  }
  for (const auto& [label, centres] : space.parts) canvas.Tint(centres, tint_px, colors[label]);
  for (std::size_t i = 0; i < requests.size(); ++i) {
    for (const EndpointRequest& request : requests[i]) {
      DrawRequest(canvas, grid, request, options.snap_radius_m, i == 0 ? kStartColor : kGoalColor);
    }
  }
  const double radius_px = canvas.ToPixels(space.map.robot_radius_m);
  for (const Eigen::Vector2d& point : Bottlenecks(options, grid, space, requests)) {
    canvas.Ring(point, radius_px, kNarrowest);
    canvas.Label(point, static_cast<int>(radius_px), 2, "too narrow", kNarrowest);
  }
  canvas.ScaleBar(kInkColor);
  return canvas.Picture();
}

}  // namespace nightmap
