// SPDX-License-Identifier: Apache-2.0
// Walls: weak plaster, at times a stripe all along, rarely posters.
#include "pipeline/base/random.h"
#include "stages/ceiling/synthesize_ceiling/ceiling_world.h"

namespace nightmap {

namespace {

constexpr std::uint64_t kWallStream = 705;
constexpr double kWallCell_m = 0.008;
constexpr float kWallBrightness = 140;

void PaintPoster(CeilingRaster& raster, double left_m, Random& random) {
  constexpr int kNumPatches = 7;
  const double width_m = random.Uniform(0.5, 0.8);
  const double low_m = random.Uniform(1.4, 1.6);
  const double high_m = low_m + random.Uniform(0.5, 0.7);
  raster.Box({left_m, low_m, left_m + width_m, high_m}, 200);
  for (int i = 0; i < kNumPatches; ++i) {
    const double x = random.Uniform(left_m, left_m + 0.7 * width_m);
    const double y = random.Uniform(low_m, low_m + 0.7 * (high_m - low_m));
    const double patch_width_m = random.Uniform(0.08, 0.3) * width_m;
    const double patch_height_m = random.Uniform(0.08, 0.3) * (high_m - low_m);
    raster.Box({x, y, x + patch_width_m, y + patch_height_m},
               static_cast<float>(random.Uniform(20, 160)));
  }
}

}  // namespace

CeilingRaster PaintWall(const CeilingRect& rect, int side, int seed) {
  const bool is_along_y = side < 2;
  const double length_m = is_along_y ? rect.area.y1 - rect.area.y0 : rect.area.x1 - rect.area.x0;
  // One colour has no more to say than one cell.
  if (rect.finish == CeilingFinish::kBlank) {
    return CeilingRaster(kWallCell_m, kWallCell_m, kWallCell_m, kWallBrightness);
  }
  CeilingRaster raster(length_m, rect.height_m, kWallCell_m, kWallBrightness);
  Random random(static_cast<std::uint64_t>(seed),
                kWallStream,
                static_cast<std::uint64_t>(4 * rect.look + side));
  raster.MultiplyNoise(0.04F, 0.4, random.Next());
  raster.MultiplyNoise(0.03F, 0.06, random.Next());
  if (rect.finish == CeilingFinish::kPaint) return raster;
  constexpr double kStripe_m = 0.08, kPosterPitch_m = 3, kPosterWidth_m = 0.8;
  if (random.Uniform() < 0.4) {
    const double height_m = random.Uniform(1.95, 2.2);
    raster.Box({0, height_m, length_m, height_m + kStripe_m}, 95);
  }
  for (double left_m = 0.5; left_m + kPosterPitch_m / 2 + kPosterWidth_m < length_m;
       left_m += kPosterPitch_m) {
    if (random.Uniform() < 0.25) {
      PaintPoster(raster, left_m + random.Uniform(0, kPosterPitch_m / 2), random);
    }
  }
  return raster;
}

}  // namespace nightmap
