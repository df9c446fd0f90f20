// SPDX-License-Identifier: Apache-2.0
// Lamps, vents, sprinklers, smoke detectors and pipes on the ceilings of a CeilingPlan.
#include <algorithm>
#include <cmath>

#include "pipeline/base/random.h"
#include "stages/ceiling/synthesize_ceiling/ceiling_plan.h"

namespace nightmap {

namespace {

constexpr std::uint64_t kFittingStream = 701;
constexpr double kMargin_m = 0.45;  // from the walls to the middle of a fitting

// Places fittings by their middle: `along` the longer side of a ceiling, and `across` from the
// middle of it.
class FittingPlacer {
 public:
  FittingPlacer(int rect, CeilingPlan& plan)
      : rect_(rect), area_(plan.rects[static_cast<std::size_t>(rect)].area), plan_(plan) {}

  bool IsAlongX() const { return area_.x1 - area_.x0 >= area_.y1 - area_.y0; }
  double Length_m() const { return std::max(area_.x1 - area_.x0, area_.y1 - area_.y0); }
  double Width_m() const { return std::min(area_.x1 - area_.x0, area_.y1 - area_.y0); }

  // Nothing is placed onto another fitting.
  void Add(FittingKind kind, double along_m, double across_m, double length_m, double width_m) {
    const double x = IsAlongX() ? area_.x0 + along_m : (area_.x0 + area_.x1) / 2 + across_m;
    const double y = IsAlongX() ? (area_.y0 + area_.y1) / 2 + across_m : area_.y0 + along_m;
    const double half_x = (IsAlongX() ? length_m : width_m) / 2;
    const double half_y = (IsAlongX() ? width_m : length_m) / 2;
    const Rect2 area{x - half_x, y - half_y, x + half_x, y + half_y};
    for (const CeilingFitting& other : plan_.fittings) {
      if (area.x0 < other.area.x1 && other.area.x0 < area.x1 && area.y0 < other.area.y1 &&
          other.area.y0 < area.y1) {
        return;
      }
    }
    plan_.fittings.push_back({kind, area, rect_});
  }

 private:
  int rect_;
  Rect2 area_;
  CeilingPlan& plan_;
};

void AddSmall(FittingPlacer& placer, double along_m, double across_m, Random& random) {
  constexpr double kVent_m = 0.45, kSprinkler_m = 0.11, kDetector_m = 0.12;
  const double kind = random.Uniform();
  if (kind < 0.35) {
    placer.Add(FittingKind::kVent, along_m, across_m, kVent_m, kVent_m);
  } else if (kind < 0.75) {
    placer.Add(FittingKind::kSprinkler, along_m, across_m, kSprinkler_m, kSprinkler_m);
  } else {
    placer.Add(FittingKind::kSmokeDetector, along_m, across_m, kDetector_m, kDetector_m);
  }
}

// Middle of the tile at a place; the grid begins half a tile from the middle of a ceiling's width.
double TileMiddle_m(double along_m) {
  return (std::floor(along_m / kCeilingTile_m) + 0.5) * kCeilingTile_m;
}

void AddRegular(FittingPlacer& placer) {
  constexpr double kPitch_m = 4 * kCeilingTile_m, kSprinkler_m = 0.11;
  for (double along_m = 1.5 * kCeilingTile_m; along_m < placer.Length_m() - kMargin_m;
       along_m += kPitch_m) {
    placer.Add(FittingKind::kLamp, along_m, 0, kCeilingTile_m, kCeilingTile_m);
    const double next_m = along_m + kPitch_m / 2;
    if (next_m > placer.Length_m() - kMargin_m) continue;
    placer.Add(FittingKind::kSprinkler, next_m, 0, kSprinkler_m, kSprinkler_m);
  }
}

void AddIrregular(FittingPlacer& placer, bool is_tiled, Random& random) {
  constexpr double kLampPitch_m = 4 * kCeilingTile_m;
  const double lane_m = std::max(0.0, placer.Width_m() / 2 - 1);  // 0 in a corridor
  for (double along_m = 1.5; along_m < placer.Length_m() - 0.9; along_m += kLampPitch_m) {
    if (random.Uniform() < 0.25) continue;
    const bool is_long = random.Uniform() < 0.5;
    const double at_m = is_tiled ? TileMiddle_m(along_m) : along_m + random.Uniform(-0.4, 0.4);
    for (const double across_m : {-lane_m, lane_m}) {
      const double lane_tile_m = std::round(across_m / kCeilingTile_m) * kCeilingTile_m;
      placer.Add(FittingKind::kLamp, at_m, lane_tile_m, is_long ? 1.2 : 0.6, is_long ? 0.3 : 0.6);
    }
  }
  const auto num_small = static_cast<int>(placer.Length_m() * placer.Width_m() / 2.5);
  for (int i = 0; i < num_small; ++i) {
    const double half_m = placer.Width_m() / 2 - kMargin_m;
    double along_m = random.Uniform(kMargin_m, placer.Length_m() - kMargin_m);
    const double across_m = random.Uniform(-half_m, half_m);
    if (is_tiled) along_m = TileMiddle_m(along_m);
    AddSmall(placer, along_m, across_m, random);
  }
}

}  // namespace

void AddFittings(int rect, int seed, CeilingPlan& plan) {
  const CeilingRect& ceiling = plan.rects[static_cast<std::size_t>(rect)];
  Random random(
      static_cast<std::uint64_t>(seed), kFittingStream, static_cast<std::uint64_t>(ceiling.look));
  FittingPlacer placer(rect, plan);
  constexpr double kHighCeiling_m = 2.9, kPipe_m = 0.08;
  if (ceiling.height_m > kHighCeiling_m) {
    placer.Add(FittingKind::kPipe, placer.Length_m() / 2, 0.7, placer.Length_m(), kPipe_m);
  }
  switch (ceiling.finish) {
    case CeilingFinish::kRepeated:
      AddRegular(placer);
      break;
    case CeilingFinish::kMineral:
      AddIrregular(placer, true, random);
      break;
    case CeilingFinish::kPlaster:
      AddIrregular(placer, false, random);
      break;
    case CeilingFinish::kBlank:
    case CeilingFinish::kPaint:
      break;
  }
}

}  // namespace nightmap
