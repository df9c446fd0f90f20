// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/texture.h"

#include <smmintrin.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "pipeline/base/error.h"

namespace nightmap {

namespace {

// Texels lie in blocks of 4x4, a cache line each. In rows, neighbours above each other would lie a
// power of two apart and push each other out of the cache. The place of a texel is the sum of that
// of its row and that of its column.
std::size_t RowStart(int y, int width) {
  const auto row = static_cast<std::size_t>(y);
  const std::size_t blocks_per_row = (static_cast<std::size_t>(width) + 3) / 4;
  return row / 4 * blocks_per_row * 64 + row % 4 * 16;
}

std::size_t InRow(int x) {
  const auto column = static_cast<std::size_t>(x);
  return column / 4 * 64 + column % 4 * 4;
}

std::size_t TexelIdx(int x, int y, int width) { return RowStart(y, width) + InRow(x); }

std::size_t NumBytes(int width, int height) { return RowStart((height + 3) / 4 * 4, width); }

// The compiler does not find the instruction that widens four bytes at once.
Eigen::Vector4f ToFloats(const std::uint8_t* rgbx) {
  std::int32_t bytes = 0;
  std::memcpy(&bytes, rgbx, sizeof(bytes));
  Eigen::Vector4f floats;
  _mm_store_ps(floats.data(), _mm_cvtepi32_ps(_mm_cvtepu8_epi32(_mm_cvtsi32_si128(bytes))));
  return floats;
}

// Between four texels, of which (x, y) is the first; wraps around.
inline Eigen::Vector4f Bilinear(const Texture::Level& level, int x, int y, float fx, float fy) {
  const std::uint8_t* top = &level.rgbx[RowStart(y & (level.height - 1), level.width)];
  const std::uint8_t* bottom = &level.rgbx[RowStart((y + 1) & (level.height - 1), level.width)];
  const std::size_t left = InRow(x & (level.width - 1));
  const std::size_t right = InRow((x + 1) & (level.width - 1));
  return (1 - fy) * ((1 - fx) * ToFloats(top + left) + fx * ToFloats(top + right)) +
         fy * ((1 - fx) * ToFloats(bottom + left) + fx * ToFloats(bottom + right));
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
  finest.rgbx.resize(NumBytes(image.width, image.height));
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      std::copy_n(&image.pixels[3 * static_cast<std::size_t>(y * image.width + x)],
                  3,
                  &finest.rgbx[TexelIdx(x, y, image.width)]);
    }
  }
  levels_.push_back(std::move(finest));
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    levels_.push_back(Halve(levels_.back()));
  }
}

Texture::Level Texture::Halve(const Level& fine) {
  Level coarse{std::max(1, fine.width / 2), std::max(1, fine.height / 2), {}};
  coarse.rgbx.resize(NumBytes(coarse.width, coarse.height));
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

Texture::Filter Texture::FilterOf(float footprint) const {
  const float texels = footprint * static_cast<float>(levels_.front().width);
  const float last_level = static_cast<float>(levels_.size() - 1);
  const float level = texels > 1 ? std::min(std::log2(texels), last_level) : 0.0F;
  const auto fine_idx = static_cast<std::size_t>(level);
  const Level& fine = levels_[fine_idx];
  const Level& coarse = levels_[std::min(fine_idx + 1, levels_.size() - 1)];
  const Eigen::Array4i sizes(fine.width, fine.height, coarse.width, coarse.height);
  return {&fine, &coarse, level - static_cast<float>(fine_idx), sizes.cast<float>()};
}

Eigen::Vector4f Texture::Sample(const Eigen::Vector2f& uv, const Filter& filter) {
  const Eigen::Array4f at = Eigen::Array4f(uv.x(), uv.y(), uv.x(), uv.y()) * filter.sizes - 0.5F;
  const Eigen::Array4f first = at.floor();
  const Eigen::Array4f fraction = at - first;
  const Eigen::Array4i texel = first.cast<int>();
  const Eigen::Vector4f fine = Bilinear(*filter.fine, texel[0], texel[1], fraction[0], fraction[1]);
  if (filter.blend == 0.0F) return fine;
  return (1 - filter.blend) * fine +
         filter.blend * Bilinear(*filter.coarse, texel[2], texel[3], fraction[2], fraction[3]);
}

}  // namespace nightmap
