// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "pipeline/plan/draw_on_grid.h"
#include "stages/laser/objects/objects.h"

namespace nightmap {
namespace {

constexpr int kTargetSide_px = 2000;
constexpr int kMaxScale = 12;
constexpr int kThickness_px = 2;
constexpr Rgb kFrame = {210, 40, 40};
constexpr Rgb kInk = {30, 30, 30};

}  // namespace

ColorImage DrawObjects(const OccupancyGrid& grid, const std::vector<MapObject>& objects) {
  const int scale =
      std::clamp(kTargetSide_px / std::max({1, grid.width, grid.height}), 1, kMaxScale);
  GridCanvas canvas(grid, scale, true);
  for (const MapObject& object : objects) {
    canvas.Rectangle(object.map_from_object, object.size_m, kFrame, kThickness_px);
  }
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
