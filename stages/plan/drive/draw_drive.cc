// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "pipeline/plan/draw_on_grid.h"
#include "stages/plan/drive/drive_output.h"

namespace nightmap {
namespace {

constexpr double kTargetSide_px = 360;
// Colors for drawing without anti-aliasing, because a GIF has few.
constexpr Rgb kPathColor = {130, 170, 230};
constexpr Rgb kDrivenColor = {20, 80, 200};
constexpr Rgb kRobotColor = {20, 150, 60};
constexpr Rgb kHeadingColor = {255, 255, 255};
constexpr Rgb kGoalColor = {210, 40, 40};

void DrawDisc(GridCanvas& canvas,
              const Eigen::Vector2d& center,
              double radius_m,
              const Rgb& color) {
  canvas.Disc(center, std::max(2.0, canvas.ToPixels(radius_m)), color);
}

void DrawRobot(GridCanvas& canvas, const PlanarPose& pose, double radius_m) {
  const Eigen::Vector2d ahead(std::cos(pose.heading_rad), std::sin(pose.heading_rad));
  DrawDisc(canvas, pose.point_in_map, radius_m, kRobotColor);
  canvas.Line(pose.point_in_map, pose.point_in_map + radius_m * ahead, kHeadingColor);
}

}  // namespace

std::vector<ColorImage> DrawDrive(const DriveInputs& inputs, const DriveResult& result) {
  const OccupancyGrid& grid = inputs.grid;
  GridCanvas driven(grid, kTargetSide_px / std::max(grid.width, grid.height), false);
  for (const auto& leg : inputs.path.legs_in_map) {
    for (std::size_t i = 1; i < leg.size(); ++i) driven.Line(leg[i - 1], leg[i], kPathColor);
    DrawDisc(driven, leg.back(), 0.5 * result.footprint.radius_m, kGoalColor);
  }

  std::vector<ColorImage> images;
  const std::size_t last = result.steps.size() - 1;
  const std::size_t stride =
      std::max<std::size_t>(1, (last + kMaxDriveImages - 2) / (kMaxDriveImages - 1));
  for (std::size_t i = 0; i <= last; ++i) {
    const PlanarPose& pose = result.steps[i].pose;
    if (i > 0) driven.Line(result.steps[i - 1].pose.point_in_map, pose.point_in_map, kDrivenColor);
    if (i % stride != 0 && i != last) continue;
    GridCanvas canvas = driven;
    DrawRobot(canvas, pose, result.footprint.radius_m);
    images.push_back(canvas.Picture());
  }
  return images;
}

}  // namespace nightmap
