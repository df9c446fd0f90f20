// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "pipeline/planar/draw_on_grid.h"
#include "stages/objects/objects.h"

namespace nightmap {
namespace {

constexpr int kTargetSide_px = 2000;
constexpr int kMaxScale = 12;
constexpr int kThickness_px = 2;
constexpr Rgb kFrame = {210, 40, 40};
constexpr Rgb kInk = {30, 30, 30};

void DrawRectangle(GridCanvas& canvas, const MapObject& object) {
  const Eigen::Vector2d half_m = object.size_m / 2;
  const auto corner = [&](double x, double y) {
    return object.map_from_object * Eigen::Vector2d(x * half_m.x(), y * half_m.y());
  };
  canvas.Line(corner(-1, -1), corner(1, -1), kFrame, kThickness_px);
  canvas.Line(corner(1, -1), corner(1, 1), kFrame, kThickness_px);
  canvas.Line(corner(1, 1), corner(-1, 1), kFrame, kThickness_px);
  canvas.Line(corner(-1, 1), corner(-1, -1), kFrame, kThickness_px);
}

}  // namespace

ColorImage DrawObjects(const OccupancyGrid& grid, const std::vector<MapObject>& objects) {
  const int scale =
      std::clamp(kTargetSide_px / std::max({1, grid.width, grid.height}), 1, kMaxScale);
  GridCanvas canvas(grid, scale, true);
  for (const MapObject& object : objects) DrawRectangle(canvas, object);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const int beside_px = static_cast<int>(canvas.ToPixels(objects[i].size_m.maxCoeff() / 2));
    canvas.Label(objects[i].map_from_object.translation,
                 beside_px + 2,
                 beside_px / 2,
                 std::to_string(i + 1),
                 kFrame);
  }
  canvas.ScaleBar(kInk);
  return canvas.Picture();
}

}  // namespace nightmap
