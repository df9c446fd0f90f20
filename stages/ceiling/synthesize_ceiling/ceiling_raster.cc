// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/synthesize_ceiling/ceiling_raster.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>

#include "pipeline/base/random.h"

namespace nightmap {

namespace {

constexpr std::uint64_t kLatticeStream = 702;

// About log2(x), continuous and rising: exact at powers of two.
float FastLog2(float x) {
  const auto bits = std::bit_cast<std::uint32_t>(x);
  const auto exponent = static_cast<float>(static_cast<int>(bits >> 23) - 127);
  const float mantissa = std::bit_cast<float>((bits & 0x7fffffU) | 0x3f800000U);
  return exponent + mantissa - 1;
}

// Length of [low, high] within cell i of unit length.
float Overlap(double low, double high, int i) {
  return static_cast<float>(std::clamp(std::min(high, i + 1.0) - std::max(low, i + 0.0), 0.0, 1.0));
}

void Blend(float& value, float brightness, float opacity) {
  value += opacity * (brightness - value);
}

}  // namespace

// `x`, `y` count cells from the middle of the first.
inline float CeilingRaster::Level::Bilinear(float x, float y) const {
  x = std::min(std::max(x, 0.0F), static_cast<float>(width - 1));
  y = std::min(std::max(y, 0.0F), static_cast<float>(height - 1));
  const int x0 = static_cast<int>(x);
  const int y0 = static_cast<int>(y);
  const float fx = x - static_cast<float>(x0);
  const float fy = y - static_cast<float>(y0);
  const std::ptrdiff_t right = x0 + 1 < width ? 1 : 0;
  const std::ptrdiff_t below = y0 + 1 < height ? width : 0;
  const float* at = values.data() + static_cast<std::ptrdiff_t>(y0) * width + x0;
  const float top = at[0] + fx * (at[right] - at[0]);
  const float bottom = at[below] + fx * (at[below + right] - at[below]);
  return top + fy * (bottom - top);
}

CeilingRaster::CeilingRaster(double width_m, double height_m, double cell_m, float brightness)
    : cell_m_(cell_m), cells_per_m_(1 / cell_m) {
  Level level{static_cast<int>(std::ceil(width_m / cell_m - 1e-9)),
              static_cast<int>(std::ceil(height_m / cell_m - 1e-9)),
              {}};
  level.values.assign(
      static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height), brightness);
  levels_.push_back(std::move(level));
}

void CeilingRaster::Box(const Rect2& area, float brightness, float opacity) {
  Level& level = levels_.front();
  const Rect2 px{area.x0 / cell_m_, area.y0 / cell_m_, area.x1 / cell_m_, area.y1 / cell_m_};
  const int y_end = std::min(level.height, static_cast<int>(std::ceil(px.y1)));
  const int x_end = std::min(level.width, static_cast<int>(std::ceil(px.x1)));
  for (int y = std::max(0, static_cast<int>(std::floor(px.y0))); y < y_end; ++y) {
    const float row_share = opacity * Overlap(px.y0, px.y1, y);
    for (int x = std::max(0, static_cast<int>(std::floor(px.x0))); x < x_end; ++x) {
      Blend(level.At(x, y), brightness, row_share * Overlap(px.x0, px.x1, x));
    }
  }
}

void CeilingRaster::Disc(const Eigen::Vector2d& center,
                         double radius_m,
                         float brightness,
                         float opacity) {
  Level& level = levels_.front();
  const Eigen::Vector2d px = center / cell_m_;
  const double radius = radius_m / cell_m_;
  const int y_end = std::min(level.height, static_cast<int>(std::ceil(px.y() + radius)) + 1);
  const int x_end = std::min(level.width, static_cast<int>(std::ceil(px.x() + radius)) + 1);
  for (int y = std::max(0, static_cast<int>(px.y() - radius) - 1); y < y_end; ++y) {
    for (int x = std::max(0, static_cast<int>(px.x() - radius) - 1); x < x_end; ++x) {
      const double inside = radius - std::hypot(x + 0.5 - px.x(), y + 0.5 - px.y());
      const auto coverage = static_cast<float>(std::clamp(inside + 0.5, 0.0, 1.0));
      if (coverage > 0) Blend(level.At(x, y), brightness, opacity * coverage);
    }
  }
}

void CeilingRaster::MultiplyNoise(float amplitude, double cell_m, std::uint64_t seed) {
  Level& level = levels_.front();
  const double per_px = cell_m_ / cell_m;
  const int columns = static_cast<int>(level.width * per_px) + 2;
  const int rows = static_cast<int>(level.height * per_px) + 2;
  Level lattice{columns, rows, {}};
  Random random(seed, kLatticeStream);
  for (int i = 0; i < columns * rows; ++i) {
    lattice.values.push_back(static_cast<float>(random.Uniform(-1, 1)));
  }
  for (int y = 0; y < level.height; ++y) {
    for (int x = 0; x < level.width; ++x) {
      const auto u = static_cast<float>((x + 0.5) * per_px);
      const auto v = static_cast<float>((y + 0.5) * per_px);
      level.At(x, y) *= 1 + amplitude * lattice.Bilinear(u, v);
    }
  }
}

void CeilingRaster::Finish() {
  while (levels_.back().width > 1 && levels_.back().height > 1) {
    levels_.push_back(Halve(levels_.back()));
  }
}

CeilingRaster::Level CeilingRaster::Halve(const Level& fine) {
  Level coarse{(fine.width + 1) / 2, (fine.height + 1) / 2, {}};
  coarse.values.resize(static_cast<std::size_t>(coarse.width) *
                       static_cast<std::size_t>(coarse.height));
  for (int y = 0; y < coarse.height; ++y) {
    const int below = std::min(2 * y + 1, fine.height - 1);
    for (int x = 0; x < coarse.width; ++x) {
      const int right = std::min(2 * x + 1, fine.width - 1);
      coarse.At(x, y) = (fine.At(2 * x, 2 * y) + fine.At(right, 2 * y) + fine.At(2 * x, below) +
                         fine.At(right, below)) /
                        4;
    }
  }
  return coarse;
}

float CeilingRaster::Sample(double x_m, double y_m, double footprint_m) const {
  const auto x = static_cast<float>(x_m * cells_per_m_);
  const auto y = static_cast<float>(y_m * cells_per_m_);
  const auto last = static_cast<float>(levels_.size() - 1);
  const float level =
      std::clamp(FastLog2(static_cast<float>(footprint_m * cells_per_m_)), 0.0F, last);
  const auto fine_idx = static_cast<std::size_t>(level);
  const float blend = level - static_cast<float>(fine_idx);
  const float scale = std::bit_cast<float>(static_cast<std::uint32_t>(127 - fine_idx) << 23);
  const float fine = levels_[fine_idx].Bilinear(x * scale - 0.5F, y * scale - 0.5F);
  if (blend == 0) return fine;
  const float half = scale / 2;
  const float coarse = levels_[fine_idx + 1].Bilinear(x * half - 0.5F, y * half - 0.5F);
  return fine + blend * (coarse - fine);
}

}  // namespace nightmap
