// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "pipeline/base/random.h"
#include "stages/ceiling/synthesize_ceiling/ceiling_render.h"

namespace nightmap {

namespace {

constexpr std::uint64_t kNoiseTableStream = 706;
constexpr std::uint64_t kPixelNoiseStream = 707;

// Gaussian numbers to draw from by 16 random bits: ten times as quick as to compute each.
const std::vector<float>& GaussianTable() {
  static const std::vector<float> table = [] {
    Random random(0, kNoiseTableStream);
    std::vector<float> numbers(1 << 16);
    for (float& number : numbers) number = static_cast<float>(random.Gaussian());
    return numbers;
  }();
  return table;
}

std::uint8_t ToLevel(float value) {
  return static_cast<std::uint8_t>(std::floor(std::clamp(value, 0.0F, 255.0F) + 0.5F));
}

}  // namespace

ColorImage ExposeCeiling(const Image<float>& radiance,
                         const SensorNoise& noise,
                         std::uint64_t seed) {
  const std::vector<float>& gaussian = GaussianTable();
  const auto sigma = static_cast<float>(noise.noise_levels);
  const double center_x = (radiance.width - 1) / 2.0;
  const double center_y = (radiance.height - 1) / 2.0;
  const double per_corner = noise.vignetting / (center_x * center_x + center_y * center_y);
  Random random(seed, kPixelNoiseStream);
  ColorImage image{radiance.width, radiance.height, 3, {}};
  image.pixels.resize(radiance.pixels.size());
  std::size_t i = 0;
  for (int y = 0; y < radiance.height; ++y) {
    for (int x = 0; x < radiance.width; ++x) {
      const double squared = (x - center_x) * (x - center_x) + (y - center_y) * (y - center_y);
      const auto gain = static_cast<float>(noise.gain * (1 - per_corner * squared));
      const std::uint64_t bits = random.Next();
      for (int c = 0; c < 3; ++c, ++i) {
        const float deviation = sigma * gaussian[(bits >> (16 * c)) & 0xffff];
        image.pixels[i] = ToLevel(gain * radiance.pixels[i] + deviation);
      }
    }
  }
  return image;
}

}  // namespace nightmap
