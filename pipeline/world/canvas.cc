// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/canvas.h"

#include <algorithm>
#include <cmath>

namespace nightmap {

namespace {

float Blend(float t) { return t * t * t * (t * (t * 6 - 15) + 10); }

// Smooth noise in [0, 1) that repeats after period_x, period_y lattice cells (value noise, quintic
// blend). The lattice is drawn once: it is much smaller than the picture.
class PeriodicNoise {
 public:
  PeriodicNoise(int period_x, int period_y, std::uint64_t seed)
      : period_x_(period_x), period_y_(period_y) {
    Random random(seed);
    values_.resize(static_cast<std::size_t>(period_x) * static_cast<std::size_t>(period_y));
    for (float& value : values_) value = static_cast<float>(random.Uniform());
  }

  // x in [0, period_x), y in [0, period_y).
  float At(float x, float y) const {
    const int x0 = static_cast<int>(x);
    const int y0 = static_cast<int>(y);
    const float bx = Blend(x - static_cast<float>(x0));
    const float by = Blend(y - static_cast<float>(y0));
    const float top = Value(x0, y0) * (1 - bx) + Value(x0 + 1, y0) * bx;
    const float bottom = Value(x0, y0 + 1) * (1 - bx) + Value(x0 + 1, y0 + 1) * bx;
    return top * (1 - by) + bottom * by;
  }

 private:
  float Value(int x, int y) const {
    return values_[static_cast<std::size_t>(y % period_y_) * static_cast<std::size_t>(period_x_) +
                   static_cast<std::size_t>(x % period_x_)];
  }

  int period_x_;
  int period_y_;
  std::vector<float> values_;
};

}  // namespace

Canvas::Canvas(int size_px, const Eigen::Vector3f& color)
    : size_px_(size_px), pixels_(static_cast<std::size_t>(size_px * size_px), color) {}

Eigen::Vector3f& Canvas::At(int x, int y) {
  const int mask = size_px_ - 1;
  return pixels_[static_cast<std::size_t>((y & mask) * size_px_ + (x & mask))];
}

void Canvas::Blob(const Eigen::Vector2f& center,
                  const Eigen::Vector2f& radii,
                  float angle_rad,
                  float sharpness,
                  const Eigen::Vector3f& color,
                  float opacity) {
  const float size = static_cast<float>(size_px_);
  const Eigen::Vector2f c = center * size;
  const Eigen::Vector2f r = (radii * size).cwiseMax(0.5F);
  const int reach = static_cast<int>(std::ceil(r.norm())) + 1;
  const float cos_angle = std::cos(angle_rad);
  const float sin_angle = std::sin(angle_rad);
  const int cx = static_cast<int>(c.x());
  const int cy = static_cast<int>(c.y());
  for (int y = cy - reach; y <= cy + reach; ++y) {
    for (int x = cx - reach; x <= cx + reach; ++x) {
      const float dx = static_cast<float>(x) + 0.5F - c.x();
      const float dy = static_cast<float>(y) + 0.5F - c.y();
      const float u = std::abs(cos_angle * dx + sin_angle * dy) / r.x();
      const float v = std::abs(cos_angle * dy - sin_angle * dx) / r.y();
      if (u > 1.5F || v > 1.5F) continue;
      const float distance =
          std::pow(std::pow(u, sharpness) + std::pow(v, sharpness), 1 / sharpness);
      const float cover = std::clamp((1 - distance) * r.minCoeff() + 0.5F, 0.0F, 1.0F) * opacity;
      Eigen::Vector3f& pixel = At(x, y);
      pixel += cover * (color - pixel);
    }
  }
}

void Canvas::Rectangle(const Eigen::Vector2f& low,
                       const Eigen::Vector2f& high,
                       const Eigen::Vector3f& color) {
  const float size = static_cast<float>(size_px_);
  const auto to_px = [size](float value) { return static_cast<int>(std::lround(value * size)); };
  for (int y = to_px(low.y()); y < to_px(high.y()); ++y) {
    for (int x = to_px(low.x()); x < to_px(high.x()); ++x) At(x, y) = color;
  }
}

void Canvas::Glyphs(const Eigen::Vector2f& low,
                    float width,
                    float height,
                    const Eigen::Vector3f& color,
                    Random& random) {
  const float cell = height / 6;
  const float pitch = 5 * cell;
  for (float x = low.x(); x + 4 * cell <= low.x() + width; x += pitch) {
    const std::uint64_t bits = random.Next();
    if (bits % 7 == 0) continue;  // a space between words
    for (int i = 0; i < 24; ++i) {
      const int row = i / 4;
      if (((bits >> (8 + i)) & 1U) == 0) continue;
      const Eigen::Vector2f corner(x + static_cast<float>(i % 4) * cell,
                                   low.y() + static_cast<float>(row) * cell);
      Rectangle(corner, corner + Eigen::Vector2f(cell, cell), color);
    }
  }
}

void Canvas::MultiplyNoise(
    float amplitude, int cells_x, int cells_y, int octaves, std::uint64_t seed) {
  for (int octave = 0; octave < octaves; ++octave) {
    const int period_x = cells_x << octave;
    const int period_y = cells_y << octave;
    const PeriodicNoise noise(period_x, period_y, seed + static_cast<std::uint64_t>(octave));
    const float scale_x = static_cast<float>(period_x) / static_cast<float>(size_px_);
    const float scale_y = static_cast<float>(period_y) / static_cast<float>(size_px_);
    for (int y = 0; y < size_px_; ++y) {
      for (int x = 0; x < size_px_; ++x) {
        const float value =
            noise.At(static_cast<float>(x) * scale_x, static_cast<float>(y) * scale_y);
        At(x, y) *= 1 + amplitude * (2 * value - 1);
      }
    }
    amplitude *= 0.75F;
  }
}

ColorImage Canvas::ToImage() const {
  ColorImage image{size_px_, size_px_, 3, {}};
  image.pixels.reserve(pixels_.size() * 3);
  for (const Eigen::Vector3f& pixel : pixels_) {
    for (int c = 0; c < 3; ++c) {
      image.pixels.push_back(
          static_cast<std::uint8_t>(std::lround(std::clamp(pixel[c], 0.0F, 255.0F))));
    }
  }
  return image;
}

Eigen::Vector3f RandomColor(Random& random, float darkest, float brightest) {
  Eigen::Vector3f color;
  for (int c = 0; c < 3; ++c) color[c] = static_cast<float>(random.Uniform(darkest, brightest));
  return color;
}

}  // namespace nightmap
