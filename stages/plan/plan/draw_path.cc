// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <algorithm>

#include "pipeline/plan/draw_on_grid.h"
#include "pipeline/plan/unknown_holes.h"
#include "stages/plan/plan/colors.h"
#include "stages/plan/plan/path_output.h"

namespace nightmap {
namespace {

constexpr int kTargetSide_px = 1200;
constexpr int kMaxScale = 12;
constexpr Rgb kTrajectory = {225, 190, 140};
constexpr Rgb kSwath = {190, 215, 245};
constexpr Rgb kHole = {205, 225, 185};
constexpr Rgb kLine = {20, 80, 200};
constexpr Rgb kNarrow = {230, 120, 0};

int Thickness(const ColorImage& picture) {
  return std::max(1, std::max(picture.width, picture.height) / 400);
}

void DrawLine(GridCanvas& canvas,
              const std::vector<Eigen::Vector2d>& points,
              const Rgb& color,
              int thickness) {
  for (std::size_t i = 1; i < points.size(); ++i) {
    canvas.Line(points[i - 1], points[i], color, thickness);
  }
}

// The robot's outline at a path point.
void DrawOutline(GridCanvas& canvas,
                 const std::vector<Eigen::Vector2d>& corners,
                 const PathPoint& point) {
  std::vector<Eigen::Vector2d> outline;
  for (const Eigen::Vector2d& corner : corners) {
    outline.push_back(point.point_in_map + Eigen::Rotation2Dd(point.heading_rad) * corner);
  }
  if (!outline.empty()) outline.push_back(outline.front());
  DrawLine(canvas, outline, kInkColor, 1);
}

void DrawEnd(GridCanvas& canvas,
             const Endpoint& endpoint,
             const std::string& label,
             const Rgb& color) {
  const int radius = std::max(4, 2 * Thickness(canvas.Picture()));
  const auto& box = endpoint.request.box;
  if (box) canvas.Rectangle(box->map_from_box, box->size_m, color, Thickness(canvas.Picture()));
  if (endpoint.moved_by_m > 0) {
    canvas.Line(endpoint.request.point_in_map, endpoint.point_in_map, color);
    canvas.Ring(endpoint.request.point_in_map, radius, color);
  }
  canvas.Disc(endpoint.point_in_map, radius, color);
  canvas.Label(endpoint.point_in_map, radius + 3, radius + 2, label, color);
}

// Draws the unknown cells that count as free.
void DrawHoles(GridCanvas& canvas, const OccupancyGrid& grid, double max_hole_m) {
  for (const std::size_t index : FindUnknownHoles(grid, max_hole_m)) {
    const auto width = static_cast<std::size_t>(grid.width);
    const Eigen::Vector2i cell(static_cast<int>(index % width), static_cast<int>(index / width));
    canvas.Disc(grid.CenterInMap(cell), 0.45 * canvas.ToPixels(grid.resolution_m), kHole);
  }
}

void DrawNarrowPlaces(GridCanvas& canvas, const PlanResult& result) {
  for (const NarrowPlace& place : result.narrow_places) {
    for (std::size_t i = place.first_point; i <= place.last_point; ++i) {
      const std::size_t next = std::min(i + 1, place.last_point);
      canvas.Line(result.path[i].point_in_map,
                  result.path[next].point_in_map,
                  kNarrow,
                  2 * Thickness(canvas.Picture()));
    }
  }
}

// Draws the parts of the camera's trajectory that are on the grid's floor.
void DrawTrajectory(GridCanvas& canvas, const PlanInputs& inputs) {
  std::vector<Eigen::Vector2d> part;
  for (const StampedPose& pose : inputs.trajectory) {
    const Eigen::Vector3d& camera_in_map = pose.pose.translation;
    if (FloorBelow(inputs.floors, camera_in_map.z()) == inputs.floor_idx) {
      part.emplace_back(camera_in_map.head<2>());
      continue;
    }
    DrawLine(canvas, part, kTrajectory, 1);
    part.clear();
  }
  DrawLine(canvas, part, kTrajectory, 1);
}

}  // namespace

int PixelsPerCell(const OccupancyGrid& grid) {
  return std::clamp(kTargetSide_px / std::max(grid.width, grid.height), 1, kMaxScale);
}

ColorImage DrawPath(const PlanOptions& options,
                    const PlanInputs& inputs,
                    const PlanResult& result) {
  GridCanvas canvas(inputs.grid, PixelsPerCell(inputs.grid), true);
  DrawHoles(canvas, inputs.grid, options.cost.max_hole_m);
  std::vector<Eigen::Vector2d> path;
  for (const PathPoint& point : result.path) path.push_back(point.point_in_map);
  canvas.Tint(path, canvas.ToPixels(CircumscribedRadius_m(options.footprint)), kSwath);
  DrawTrajectory(canvas, inputs);
  DrawLine(canvas, path, kLine, Thickness(canvas.Picture()));
  DrawNarrowPlaces(canvas, result);
  const auto corners = FootprintCorners(options.footprint);
  DrawOutline(canvas, corners, result.path.front());
  for (const PlanLeg& leg : result.legs) DrawOutline(canvas, corners, result.path[leg.last_point]);
  DrawEnd(canvas, result.ends.front(), "start", kStartColor);
  for (std::size_t i = 1; i < result.ends.size(); ++i) {
    DrawEnd(canvas, result.ends[i], result.ends[i].request.role, kGoalColor);
  }
  if (inputs.floors.size() > 1) {
    const Eigen::Vector2d upper_left(0, inputs.grid.height);
    canvas.Label(inputs.grid.FromCells(upper_left), 8, 0, FloorText(result.floor), kInkColor);
  }
  canvas.ScaleBar(kInkColor);
  return canvas.Picture();
}

}  // namespace nightmap
