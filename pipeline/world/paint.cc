// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/paint.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/base/error.h"
#include "pipeline/world/canvas.h"
#include "pipeline/world/paint_pictures.h"

namespace nightmap {

namespace {

Canvas Wood(int size_px, Random& random) {
  const float brightness = Uniform(random, 0.75, 1.15);
  Canvas canvas(size_px, Eigen::Vector3f(176, 132, 88) * brightness);
  canvas.MultiplyNoise(0.16F, 2, 24, 3, random.Next());
  canvas.MultiplyNoise(0.12F, 3, 3, 3, random.Next());
  canvas.MultiplyNoise(0.12F, 12, 64, 2, random.Next());
  for (int i = 0; i < 150; ++i) {  // knots and scratches
    const float radius = Uniform(random, 0.0015, 0.011);
    canvas.Blob(RandomPoint(random),
                {radius * Uniform(random, 1, 4), radius},
                Uniform(random, -0.15, 0.15),
                2,
                Eigen::Vector3f(70, 45, 28) * Uniform(random, 0.6, 1.6),
                0.8F);
  }
  return canvas;
}

Canvas Planks(int size_px, Random& random) {
  Canvas canvas = Wood(size_px, random);
  constexpr int kNumPlanks = 16;
  for (int row = 0; row < kNumPlanks; ++row) {
    const float low = static_cast<float>(row) / kNumPlanks;
    const float high = static_cast<float>(row + 1) / kNumPlanks;
    const int row_start = static_cast<int>(low * static_cast<float>(size_px));
    const int row_end = static_cast<int>(high * static_cast<float>(size_px));
    float end = Uniform(random, 0.1, 0.3);
    float tone = Uniform(random, 0.72, 1.28);
    for (int x = 0; x < size_px; ++x) {
      const bool is_joint = static_cast<float>(x) / static_cast<float>(size_px) > end;
      if (is_joint) {
        end += Uniform(random, 0.15, 0.35);
        tone = Uniform(random, 0.72, 1.28);
      }
      for (int y = row_start; y < row_end; ++y) {
        canvas.At(x, y) *= is_joint || y == row_start ? 0.45F : tone;
      }
    }
  }
  return canvas;
}

Canvas Brick(int size_px, Random& random) {
  Canvas canvas(size_px, {188, 182, 172});
  constexpr int kNumPlanks = 24;
  constexpr int kNumColumns = 8;
  constexpr float kJoint = 0.006F;
  for (int row = 0; row < kNumPlanks; ++row) {
    const float shift = row % 2 == 0 ? 0.0F : 0.5F / kNumColumns;
    for (int column = 0; column < kNumColumns; ++column) {
      const Eigen::Vector2f low(shift + static_cast<float>(column) / kNumColumns + kJoint,
                                static_cast<float>(row) / kNumPlanks + kJoint);
      const Eigen::Vector2f size(1.0F / kNumColumns - kJoint, 1.0F / kNumPlanks - kJoint);
      const Eigen::Vector3f tone = Eigen::Vector3f(168, 96, 74) * Uniform(random, 0.62, 1.3);
      canvas.Rectangle(low, low + size, tone + RandomColor(random, -14, 14));
    }
  }
  Scatter(canvas, 900, 0.001, 0.006, 60, 200, 0.55F, random);
  canvas.MultiplyNoise(0.13F, 32, 32, 4, random.Next());
  return canvas;
}

Canvas Terrazzo(int size_px, Random& random) {
  const float tone = Uniform(random, 140, 190);
  Canvas canvas(size_px, {tone, tone * 0.98F, tone * 0.93F});
  Scatter(canvas, 2600, 0.0012, 0.011, 50, 240, 0.8F, random);
  Scatter(canvas, 160, 0.008, 0.03, 70, 220, 0.35F, random);
  canvas.MultiplyNoise(0.06F, 16, 16, 4, random.Next());
  return canvas;
}

Canvas Carpet(int size_px, Random& random) {
  Canvas canvas(size_px, RandomColor(random, 80, 150));
  Scatter(canvas, 700, 0.003, 0.03, 40, 200, 0.45F, random);
  canvas.MultiplyNoise(0.14F, 16, 16, 5, random.Next());
  return canvas;
}

Canvas Plaster(int size_px, Random& random) {
  const float tone = Uniform(random, 205, 230);
  Canvas canvas(size_px, {tone, tone * 0.99F, tone * 0.95F});
  canvas.MultiplyNoise(0.012F, 6, 6, 6, random.Next());
  Scatter(canvas, 120, 0.001, 0.004, 150, 200, 0.5F, random);
  return canvas;
}

Canvas Wallpaper(int size_px, Random& random) {
  Canvas canvas(size_px, RandomColor(random, 170, 230));
  Scatter(canvas, 420, 0.004, 0.022, 70, 230, 0.75F, random);
  canvas.MultiplyNoise(0.04F, 8, 8, 4, random.Next());
  return canvas;
}

Canvas Ceiling(int size_px, Random& random) {
  Canvas canvas(size_px, {222, 222, 218});
  Scatter(canvas, 2200, 0.0009, 0.0022, 130, 190, 0.8F, random);
  constexpr int kNumTiles = 4;
  for (int i = 0; i < kNumTiles; ++i) {
    const float at = static_cast<float>(i) / kNumTiles;
    canvas.Rectangle({at, 0}, {at + 0.008F, 1}, {150, 150, 150});
    canvas.Rectangle({0, at}, {1, at + 0.008F}, {150, 150, 150});
  }
  return canvas;
}

Canvas Fabric(int size_px, Random& random) {
  Canvas canvas(size_px, RandomColor(random, 70, 190));
  Scatter(canvas, 160, 0.01, 0.06, 30, 230, 0.6F, random);
  canvas.MultiplyNoise(0.1F, 64, 8, 3, random.Next());
  canvas.MultiplyNoise(0.1F, 8, 64, 3, random.Next());
  return canvas;
}

Canvas Mottle(int size_px, Random& random) {
  Canvas canvas(size_px, {128, 128, 128});
  canvas.MultiplyNoise(0.1F, 5, 5, 5, random.Next());
  for (int i = 0; i < 220; ++i) {  // stains and scuffs
    const float tone = Uniform(random, 70, 165);
    const Eigen::Vector2f radii(Uniform(random, 0.004, 0.02), Uniform(random, 0.003, 0.012));
    canvas.Blob(RandomPoint(random), radii, Uniform(random, 0, 3), 2, {tone, tone, tone}, 0.7F);
  }
  return canvas;
}

Canvas PaintCanvas(Paint paint, int size_px, Random& random) {
  switch (paint) {
    case Paint::kPoster:
      return Poster(size_px, random);
    case Paint::kPanel:
      return Panel(size_px, random);
    case Paint::kBooks:
      return Books(size_px, random);
    case Paint::kWood:
      return Wood(size_px, random);
    case Paint::kPlanks:
      return Planks(size_px, random);
    case Paint::kBrick:
      return Brick(size_px, random);
    case Paint::kTerrazzo:
      return Terrazzo(size_px, random);
    case Paint::kCarpet:
      return Carpet(size_px, random);
    case Paint::kPlaster:
      return Plaster(size_px, random);
    case Paint::kWallpaper:
      return Wallpaper(size_px, random);
    case Paint::kCeiling:
      return Ceiling(size_px, random);
    case Paint::kFabric:
      return Fabric(size_px, random);
    case Paint::kMottle:
      return Mottle(size_px, random);
  }
  throw UsageError("unknown paint {}", static_cast<int>(paint));
}

}  // namespace

ColorImage PaintTexture(Paint paint, int size_px, std::uint64_t seed) {
  Random random(seed, static_cast<std::uint64_t>(paint));
  return PaintCanvas(paint, size_px, random).ToImage();
}

}  // namespace nightmap
