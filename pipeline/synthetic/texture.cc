// SPDX-License-Identifier: Apache-2.0
#include "pipeline/synthetic/texture.h"

#include <smmintrin.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "pipeline/base/error.h"

namespace nightmap {

namespace {

std::size_t TexelIdx(int x, int y, int width) {
  return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
          static_cast<std::size_t>(x)) *
         4;
}

// The compiler does not find the instruction that widens four bytes at once.
Eigen::Vector4f ToFloats(const std::uint8_t* rgbx) {
  std::int32_t bytes = 0;
  std::memcpy(&bytes, rgbx, sizeof(bytes));
  Eigen::Vector4f floats;
  _mm_store_ps(floats.data(), _mm_cvtepi32_ps(_mm_cvtepu8_epi32(_mm_cvtsi32_si128(bytes))));
  return floats;
}

}  // namespace

Texture::Texture(const ColorImage& image) {
  const bool is_power_of_two = image.width > 0 && image.height > 0 &&
                               std::has_single_bit(static_cast<unsigned>(image.width)) &&
                               std::has_single_bit(static_cast<unsigned>(image.height));
  if (!is_power_of_two || image.num_channels != 3) {
    throw UsageError("texture of {}x{}x{}: sizes must be powers of two, channels 3",
                     image.width,
                     image.height,
                     image.num_channels);
  }
  Level finest{image.width, image.height, {}};
  finest.rgbx.resize(image.pixels.size() / 3 * 4);
  for (std::size_t i = 0; i < image.pixels.size() / 3; ++i) {
    std::copy_n(&image.pixels[3 * i], 3, &finest.rgbx[4 * i]);
  }
  levels_.push_back(std::move(finest));
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    levels_.push_back(Halve(levels_.back()));
  }
}

Texture::Level Texture::Halve(const Level& fine) {
  Level coarse{std::max(1, fine.width / 2), std::max(1, fine.height / 2), {}};
  coarse.rgbx.resize(TexelIdx(0, coarse.height, coarse.width));
  const int dx = fine.width > 1 ? 1 : 0;
  const int dy = fine.height > 1 ? 1 : 0;
  for (int y = 0; y < coarse.height; ++y) {
    for (int x = 0; x < coarse.width; ++x) {
      const int fx = dx != 0 ? 2 * x : x;
      const int fy = dy != 0 ? 2 * y : y;
      for (std::size_t c = 0; c < 3; ++c) {
        const int sum = fine.rgbx[TexelIdx(fx, fy, fine.width) + c] +
                        fine.rgbx[TexelIdx(fx + dx, fy, fine.width) + c] +
                        fine.rgbx[TexelIdx(fx, fy + dy, fine.width) + c] +
                        fine.rgbx[TexelIdx(fx + dx, fy + dy, fine.width) + c];
        coarse.rgbx[TexelIdx(x, y, coarse.width) + c] = static_cast<std::uint8_t>((sum + 2) / 4);
      }
    }
  }
  return coarse;
}

Eigen::Vector4f Texture::Bilinear(const Level& level, const Eigen::Vector2f& uv) {
  const float x = uv.x() * static_cast<float>(level.width) - 0.5F;
  const float y = uv.y() * static_cast<float>(level.height) - 0.5F;
  const float floor_x = std::floor(x);
  const float floor_y = std::floor(y);
  const float fx = x - floor_x;
  const float fy = y - floor_y;
  const int x0 = static_cast<int>(floor_x) & (level.width - 1);
  const int y0 = static_cast<int>(floor_y) & (level.height - 1);
  const int x1 = (x0 + 1) & (level.width - 1);
  const int y1 = (y0 + 1) & (level.height - 1);
  const auto texel = [&level](int tx, int ty) {
    return ToFloats(&level.rgbx[TexelIdx(tx, ty, level.width)]);
  };
  return (1 - fy) * ((1 - fx) * texel(x0, y0) + fx * texel(x1, y0)) +
         fy * ((1 - fx) * texel(x0, y1) + fx * texel(x1, y1));
}

Texture::Filter Texture::FilterOf(float footprint) const {
  const float texels = footprint * static_cast<float>(levels_.front().width);
  const float last_level = static_cast<float>(levels_.size() - 1);
  const float level = std::clamp(std::log2(std::max(texels, 1e-6F)), 0.0F, last_level);
  const auto fine_idx = static_cast<std::size_t>(level);
  return {fine_idx, level - static_cast<float>(fine_idx)};
}

Eigen::Vector4f Texture::Sample(const Eigen::Vector2f& uv, const Filter& filter) const {
  const Eigen::Vector4f fine = Bilinear(levels_[filter.fine_idx], uv);
  if (filter.blend == 0.0F) return fine;
  return (1 - filter.blend) * fine + filter.blend * Bilinear(levels_[filter.fine_idx + 1], uv);
}

}  // namespace nightmap
