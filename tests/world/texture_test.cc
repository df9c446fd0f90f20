// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/texture.h"

#include <gtest/gtest.h>

#include "pipeline/base/error.h"
#include "pipeline/world/paint.h"

namespace nightmap::texture_test {

ColorImage Checker() {
  ColorImage image{4, 4, 3, {}};
  for (int i = 0; i < 16; ++i) {
    const auto level = static_cast<std::uint8_t>((i + i / 4) % 2 == 0 ? 0 : 200);
    image.pixels.insert(image.pixels.end(), {level, level, level});
  }
  return image;
}

Eigen::Vector4f SampleOf(const Texture& texture, const Eigen::Vector2f& uv, float footprint) {
  return Texture::Sample(uv, texture.FilterOf(footprint));
}

TEST(Texture, ReturnsTexelsAtTheirCentres) {
  const Texture texture(Checker());
  EXPECT_NEAR(SampleOf(texture, {0.125F, 0.125F}, 0).x(), 0, 1e-4);
  EXPECT_NEAR(SampleOf(texture, {0.375F, 0.125F}, 0).x(), 200, 1e-4);
}

TEST(Texture, RepeatsBeyondItsBorder) {
  const Texture texture(Checker());
  const Eigen::Vector2f uv(0.3F, 0.7F);
  EXPECT_NEAR((SampleOf(texture, uv, 0) - SampleOf(texture, uv - Eigen::Vector2f(3, 5), 0)).norm(),
              0,
              1e-2);
}

TEST(Texture, WideFootprintGivesTheMean) {
  EXPECT_NEAR(SampleOf(Texture(Checker()), {0.2F, 0.9F}, 4).y(), 100, 1);
}

TEST(Texture, RefusesOtherSizes) {
  ColorImage image{3, 4, 3, std::vector<std::uint8_t>(36)};
  EXPECT_THROW(Texture{image}, UsageError);
}

TEST(Paint, DependsOnTheSeedOnly) {
  const ColorImage poster = PaintTexture(Paint::kPoster, 64, 5);
  EXPECT_EQ(poster.pixels, PaintTexture(Paint::kPoster, 64, 5).pixels);
  EXPECT_NE(poster.pixels, PaintTexture(Paint::kPoster, 64, 6).pixels);
}

}  // namespace nightmap::texture_test
