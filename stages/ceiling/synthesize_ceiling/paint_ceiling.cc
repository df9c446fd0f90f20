// SPDX-License-Identifier: Apache-2.0
// Ceilings: tiles, plaster and what hangs on them.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/base/random.h"
#include "stages/ceiling/synthesize_ceiling/ceiling_world.h"

namespace nightmap {

namespace {

constexpr std::uint64_t kCeilingStream = 704;
constexpr double kCeilingCell_m = 0.004;
constexpr float kTileBrightness = 165;
constexpr float kPlasterBrightness = 172;

struct CeilingPainter {
  CeilingRaster& raster;
  double width_m, height_m;
};

void PaintSpecks(CeilingRaster& raster, const Eigen::Vector2d& corner, Random random) {
  constexpr int kNumSpecks = 150;
  for (int i = 0; i < kNumSpecks; ++i) {
    const Eigen::Vector2d at = corner + Eigen::Vector2d(random.Uniform(0, kCeilingTile_m),
                                                        random.Uniform(0, kCeilingTile_m));
    const double radius_m = 0.003 * std::exp(random.Uniform(0, 1.5));
    const auto opacity = static_cast<float>(random.Uniform(0.15, 0.55));
    raster.Disc(at, radius_m, 70, opacity);
  }
}

// T-bars with the grid through the middle of a tile's side: half a tile from the ceiling's middle
// across, and from its beginning along.
void PaintTiles(const CeilingPainter& at,
                bool is_repeated,
                std::uint64_t seed,
                std::uint64_t look) {
  constexpr double kBar_m = 0.024;
  const bool is_along_x = at.width_m >= at.height_m;
  const auto first = [](double length_m) {  // of the grid across: a tile is in the middle
    const double half_m = (length_m - kCeilingTile_m) / 2;
    return half_m - std::ceil(half_m / kCeilingTile_m) * kCeilingTile_m;
  };
  const Eigen::Vector2d origin(is_along_x ? 0 : first(at.width_m),
                               is_along_x ? first(at.height_m) : 0);
  std::uint64_t tile = 0;
  for (double x = origin.x(); x < at.width_m; x += kCeilingTile_m) {
    for (double y = origin.y(); y < at.height_m; y += kCeilingTile_m, ++tile) {
      Random random(seed, kCeilingStream, (look << 32) + (is_repeated ? 0 : tile));
      const auto shade = static_cast<float>(kTileBrightness * random.Uniform(0.96, 1.04));
      at.raster.Box({x, y, x + kCeilingTile_m, y + kCeilingTile_m}, shade);
      PaintSpecks(at.raster, {x, y}, random);
    }
  }
  for (double x = origin.x(); x < at.width_m + kBar_m; x += kCeilingTile_m) {
    at.raster.Box({x - kBar_m / 2, 0, x + kBar_m / 2, at.height_m}, 112);
  }
  for (double y = origin.y(); y < at.height_m + kBar_m; y += kCeilingTile_m) {
    at.raster.Box({0, y - kBar_m / 2, at.width_m, y + kBar_m / 2}, 112);
  }
}

// A crack is a chain of small dark spots.
void PaintCrack(const CeilingPainter& at, Random& random) {
  Eigen::Vector2d point(random.Uniform(0, at.width_m), random.Uniform(0, at.height_m));
  double heading_rad = random.Uniform(0, 2 * std::numbers::pi);
  const auto num_spots = static_cast<int>(random.Uniform(50, 250));
  for (int i = 0; i < num_spots; ++i) {
    at.raster.Disc(point, 0.004, 95, 0.5F);
    heading_rad += random.Uniform(-0.25, 0.25);
    point += 0.004 * Eigen::Vector2d(std::cos(heading_rad), std::sin(heading_rad));
  }
}

void PaintPlaster(const CeilingPainter& at, Random random) {
  constexpr double kBlemishesPerM2 = 9, kCracksPerM2 = 0.3;
  at.raster.MultiplyNoise(0.03F, 0.35, random.Next());
  at.raster.MultiplyNoise(0.02F, 0.05, random.Next());
  const double area_m2 = at.width_m * at.height_m;
  for (int i = 0; i < static_cast<int>(kBlemishesPerM2 * area_m2); ++i) {
    const Eigen::Vector2d point(random.Uniform(0, at.width_m), random.Uniform(0, at.height_m));
    const double radius_m = 0.005 * std::exp(random.Uniform(0, 1.8));
    const float brightness = random.Uniform() < 0.75 ? 90 : 230;
    at.raster.Disc(point, radius_m, brightness, static_cast<float>(random.Uniform(0.2, 0.7)));
  }
  for (int i = 0; i < static_cast<int>(kCracksPerM2 * area_m2); ++i) PaintCrack(at, random);
}

void PaintVent(CeilingRaster& raster, const Rect2& area) {
  constexpr double kFrame_m = 0.03, kSlat_m = 0.028;
  raster.Box(area, 205);
  const Rect2 inner{area.x0 + kFrame_m, area.y0 + kFrame_m, area.x1 - kFrame_m, area.y1 - kFrame_m};
  raster.Box(inner, 55);
  for (double y = inner.y0 + kSlat_m / 2; y + kSlat_m / 2 < inner.y1; y += kSlat_m) {
    raster.Box({inner.x0, y, inner.x1, y + kSlat_m / 2}, 175);
  }
}

void PaintLamp(CeilingRaster& raster, const Rect2& area) {
  constexpr double kFrame_m = 0.02;
  raster.Box(area, 120);
  raster.Box({area.x0 + kFrame_m, area.y0 + kFrame_m, area.x1 - kFrame_m, area.y1 - kFrame_m},
             kLampBrightness);
}

void PaintPipe(CeilingRaster& raster, const Rect2& area) {
  constexpr double kClamp_m = 1.7, kClampLength_m = 0.03, kOverhang_m = 0.03;
  raster.Box(area, 120);
  const bool is_along_x = area.x1 - area.x0 > area.y1 - area.y0;
  const double end_m = is_along_x ? area.x1 : area.y1;
  for (double at = (is_along_x ? area.x0 : area.y0) + kClamp_m / 2; at < end_m; at += kClamp_m) {
    const Rect2 along{at, area.y0 - kOverhang_m, at + kClampLength_m, area.y1 + kOverhang_m};
    const Rect2 across{area.x0 - kOverhang_m, at, area.x1 + kOverhang_m, at + kClampLength_m};
    raster.Box(is_along_x ? along : across, 60);
  }
}

void PaintFitting(const CeilingFitting& fitting, const Rect2& ceiling, CeilingRaster& raster) {
  const Rect2& in_building = fitting.area;
  const Rect2 area{in_building.x0 - ceiling.x0,
                   in_building.y0 - ceiling.y0,
                   in_building.x1 - ceiling.x0,
                   in_building.y1 - ceiling.y0};
  const Eigen::Vector2d middle((area.x0 + area.x1) / 2, (area.y0 + area.y1) / 2);
  const double radius_m = (area.x1 - area.x0) / 2;
  switch (fitting.kind) {
    case FittingKind::kLamp:
      return PaintLamp(raster, area);
    case FittingKind::kVent:
      return PaintVent(raster, area);
    case FittingKind::kPipe:
      return PaintPipe(raster, area);
    case FittingKind::kSprinkler:
      raster.Disc(middle, radius_m, 90);
      raster.Disc(middle, 0.7 * radius_m, 215);
      return raster.Disc(middle, 0.4 * radius_m, 35);
    case FittingKind::kSmokeDetector:
      raster.Disc(middle, radius_m, 240);
      raster.Disc(middle, 0.6 * radius_m, 130);
      raster.Disc(middle, 0.5 * radius_m, 225);
      return raster.Disc(middle + Eigen::Vector2d(0.75 * radius_m, 0), 0.008, 30);
  }
}

}  // namespace

CeilingRaster PaintCeiling(const CeilingPlan& plan, int rect_idx, int seed) {
  const CeilingRect& rect = plan.rects[static_cast<std::size_t>(rect_idx)];
  const double width_m = rect.area.x1 - rect.area.x0;
  const double height_m = rect.area.y1 - rect.area.y0;
  CeilingRaster raster(width_m, height_m, kCeilingCell_m, kPlasterBrightness);
  const CeilingPainter at{raster, width_m, height_m};
  const auto world_seed = static_cast<std::uint64_t>(seed);
  const auto look = static_cast<std::uint64_t>(rect.look);
  Random random(world_seed, kCeilingStream, look << 32);
  switch (rect.finish) {
    case CeilingFinish::kMineral:
    case CeilingFinish::kRepeated:
      PaintTiles(at, rect.finish == CeilingFinish::kRepeated, world_seed, look);
      break;
    case CeilingFinish::kPlaster:
      PaintPlaster(at, random);
      break;
    case CeilingFinish::kPaint:
      raster.MultiplyNoise(0.04F, 0.05, random.Next());
      break;
    case CeilingFinish::kBlank:
      break;
  }
  for (const CeilingFitting& fitting : plan.fittings) {
    if (fitting.rect == rect_idx) PaintFitting(fitting, rect.area, raster);
  }
  return raster;
}

}  // namespace nightmap
