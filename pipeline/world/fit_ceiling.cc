// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/fit_ceiling.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace nightmap {

namespace {

constexpr std::uint64_t kFittingStream = 104;

enum class Fitting { kVent, kHatch, kTile, kSmokeDetector, kSprinkler };

constexpr std::array<double, 5> kWidth_m = {0.45, 0.5, 0.6, 0.13, 0.07};
constexpr double kGap_m = 0.08;
constexpr double kLayer_m = 0.004;  // from one layer of a fitting to the one below it

Rect2 Square(const Eigen::Vector2d& center, double half_m) {
  return {center.x() - half_m, center.y() - half_m, center.x() + half_m, center.y() + half_m};
}

bool Overlap(const Rect2& a, const Rect2& b) {
  return a.x0 < b.x1 && b.x0 < a.x1 && a.y0 < b.y1 && b.y0 < a.y1;
}

// Adds the layers of a fitting.
class Fitter {
 public:
  Fitter(double ceiling_m, SceneBuilder& builder) : ceiling_m_(ceiling_m), builder_(&builder) {}

  void Add(Fitting kind, const Rect2& area, Random& random) {
    const double width_m = area.x1 - area.x0;
    const Eigen::Vector2d center((area.x0 + area.x1) / 2, (area.y0 + area.y1) / 2);
    switch (kind) {
      case Fitting::kVent:
        Layer(area, 1, 0.75F);
        return Slats(area, random.Index(2) == 0);
      case Fitting::kHatch:
        Layer(area, 1, 0.35F);
        return Layer(Square(center, width_m / 2 - 0.02), 2, 0.9F);
      case Fitting::kTile:
        return Layer(area, 1, static_cast<float>(random.Uniform(0.6, 0.85)));
      case Fitting::kSmokeDetector:
        Layer(area, 1, 1.1F);
        return Layer(Square(center, width_m / 5), 2, 0.2F);
      case Fitting::kSprinkler:
        return Layer(area, 1, 0.15F);
    }
  }

 private:
  void Slats(const Rect2& area, bool is_along_x) {
    constexpr int kNumSlats = 5;
    const double pitch_m = (area.x1 - area.x0) / (kNumSlats + 1);
    for (int i = 0; i < kNumSlats; ++i) {
      const double low_m = (i + 0.75) * pitch_m;
      const double high_m = low_m + pitch_m / 2;
      Rect2 slat = Square({(area.x0 + area.x1) / 2, (area.y0 + area.y1) / 2}, 2 * pitch_m);
      (is_along_x ? slat.y0 : slat.x0) = (is_along_x ? area.y0 : area.x0) + low_m;
      (is_along_x ? slat.y1 : slat.x1) = (is_along_x ? area.y0 : area.x0) + high_m;
      Layer(slat, 2, 0.2F);
    }
  }
  void Layer(const Rect2& rect, int layer, float tone) {
    Surface surface;
    surface.origin = {rect.x0, rect.y0, ceiling_m_ - layer * kLayer_m};
    surface.edge_u = {rect.x1 - rect.x0, 0, 0};
    surface.edge_v = {0, rect.y1 - rect.y0, 0};
    surface.label = SurfaceLabel::kCeiling;
    surface.material = builder_->Plain(Eigen::Vector3f::Constant(tone));
    builder_->AddSurface(surface);
  }

  double ceiling_m_;
  SceneBuilder* builder_;
};

}  // namespace

void FitCeiling(
    const Rect2& rect, double ceiling_m, double per_m2, Random random, SceneBuilder& builder) {
  std::vector<Rect2> taken;
  for (const Lamp& lamp : builder.Lamps()) {
    const Eigen::Vector2d half = lamp.half_size;
    taken.push_back({lamp.center.x() - half.x(),
                     lamp.center.y() - half.y(),
                     lamp.center.x() + half.x(),
                     lamp.center.y() + half.y()});
  }
  Fitter fitter(ceiling_m, builder);
  const auto num_fittings = std::lround(per_m2 * rect.Area());
  constexpr int kAttempts = 8;  // to find room
  for (int i = 0; i < num_fittings; ++i) {
    const std::size_t kind = random.Index(kWidth_m.size());
    const double half_m = kWidth_m[kind] / 2;
    const double margin_m = half_m + kGap_m;
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const double x = random.Uniform(rect.x0 + margin_m, rect.x1 - margin_m);
      const double y = random.Uniform(rect.y0 + margin_m, rect.y1 - margin_m);
      const Eigen::Vector2d center(x, y);
      const Rect2 with_gap = Square(center, margin_m);
      const auto is_in_the_way = [&](const Rect2& other) { return Overlap(with_gap, other); };
      if (std::any_of(taken.begin(), taken.end(), is_in_the_way)) continue;
      taken.push_back(with_gap);
      fitter.Add(static_cast<Fitting>(kind), Square(center, half_m), random);
      break;
    }
  }
}

void FitCeilings(const FloorLayout& layout, const BuildingOptions& options, SceneBuilder& builder) {
  std::vector<Rect2> ceilings = {layout.corridor[0], layout.corridor[2]};
  for (const Rect2& side : {layout.corridor[1], layout.corridor[3]}) {
    ceilings.push_back({side.x0, layout.corridor[0].y1, side.x1, layout.corridor[2].y0});
  }
  for (const Room& room : layout.rooms) ceilings.push_back(room.area);
  for (std::size_t i = 0; i < ceilings.size(); ++i) {
    const Random random(static_cast<std::uint64_t>(options.seed), kFittingStream, i);
    FitCeiling(
        ceilings[i], options.ceiling_height_m, options.ceiling_fittings_per_m2, random, builder);
  }
}

}  // namespace nightmap
