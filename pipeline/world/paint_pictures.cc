// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/paint_pictures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace nightmap {

float Uniform(Random& random, double low, double high) {
  return static_cast<float>(random.Uniform(low, high));
}

Eigen::Vector2f RandomPoint(Random& random) {
  return {Uniform(random, 0, 1), Uniform(random, 0, 1)};
}

void Scatter(Canvas& canvas,
             int count,
             double min_radius,
             double max_radius,
             float darkest,
             float brightest,
             float opacity,
             Random& random) {
  for (int i = 0; i < count; ++i) {
    const double radius = min_radius * std::pow(max_radius / min_radius, random.Uniform());
    const Eigen::Vector2f radii(static_cast<float>(radius),
                                static_cast<float>(radius * random.Uniform(0.4, 1.0)));
    const Eigen::Vector2f center = RandomPoint(random);
    const float angle_rad = Uniform(random, 0, std::numbers::pi);
    const float sharpness = Uniform(random, 1.2, 6);
    canvas.Blob(
        center, radii, angle_rad, sharpness, RandomColor(random, darkest, brightest), opacity);
  }
}

Canvas Poster(int size_px, Random& random) {
  Canvas canvas(size_px, RandomColor(random, 60, 250));
  const int num_large = 4 + static_cast<int>(random.Index(5));
  Scatter(canvas, num_large, 0.12, 0.35, 20, 255, 0.9F, random);
  Scatter(canvas, 26, 0.02, 0.1, 0, 255, 1.0F, random);
  const Eigen::Vector3f ink = RandomColor(random, 0, 90);
  const int num_lines = 3 + static_cast<int>(random.Index(4));
  for (int i = 0; i < num_lines; ++i) {
    const float height = Uniform(random, 0.04, 0.11);
    const Eigen::Vector2f low(Uniform(random, 0.04, 0.3), Uniform(random, 0.03, 0.85));
    canvas.Glyphs(
        low, 0.94F - low.x(), height, i % 2 == 0 ? ink : RandomColor(random, 180, 255), random);
  }
  canvas.MultiplyNoise(0.08F, 8, 8, 3, random.Next());
  const Eigen::Vector3f frame = RandomColor(random, 10, 70);
  canvas.Rectangle({0, 0}, {1, 0.02F}, frame);
  canvas.Rectangle({0, 0.98F}, {1, 1}, frame);
  canvas.Rectangle({0, 0}, {0.02F, 1}, frame);
  canvas.Rectangle({0.98F, 0}, {1, 1}, frame);
  return canvas;
}

Canvas Panel(int size_px, Random& random) {
  Canvas canvas(size_px, RandomColor(random, 130, 200));
  canvas.MultiplyNoise(0.06F, 16, 16, 3, random.Next());
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      const Eigen::Vector2f low(
          0.05F + 0.31F * static_cast<float>(column) + Uniform(random, 0, 0.04),
          0.05F + 0.31F * static_cast<float>(row) + Uniform(random, 0, 0.04));
      canvas.Rectangle(low, low + Eigen::Vector2f(0.25F, 0.25F), RandomColor(random, 190, 255));
      for (int line = 0; line < 4; ++line) {
        const Eigen::Vector2f start(low.x() + 0.02F,
                                    low.y() + 0.02F + 0.055F * static_cast<float>(line));
        canvas.Glyphs(start, 0.2F, 0.04F, RandomColor(random, 0, 110), random);
      }
    }
  }
  return canvas;
}

Canvas Books(int size_px, Random& random) {
  Canvas canvas(size_px, {35, 30, 28});
  float x = 0;
  while (x < 1) {
    const float width = Uniform(random, 0.04, 0.11);
    const float top = Uniform(random, 0.0, 0.25);
    const Eigen::Vector3f cover = RandomColor(random, 30, 230);
    canvas.Rectangle({x, top}, {std::min(1.0F, x + width - 0.006F), 1}, cover);
    const Eigen::Vector3f ink = RandomColor(random, 0, 255);
    for (float y = top + 0.08F; y < 0.9F; y += Uniform(random, 0.06, 0.2)) {
      canvas.Glyphs({x + 0.008F, y}, std::min(width, 1 - x) - 0.014F, 0.045F, ink, random);
    }
    x += width;
  }
  return canvas;
}

}  // namespace nightmap
