// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/pixel_values.h"

#include "pipeline/base/error.h"

namespace nightmap {

ColorImage ToRgb(const Image<std::uint8_t>& image) {
  if (image.num_channels == 3) return image;
  ColorImage rgb{image.width, image.height, 3, {}};
  const std::size_t num_channels = static_cast<std::size_t>(image.num_channels);
  const std::size_t num_pixels = image.pixels.size() / num_channels;
  rgb.pixels.resize(num_pixels * 3);
  for (std::size_t i = 0; i < num_pixels; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      rgb.pixels[3 * i + c] = image.pixels[num_channels * i + (num_channels < 3 ? 0 : c)];
    }
  }
  return rgb;
}

Image<std::uint8_t> ToBytes(const Image<std::uint16_t>& image,
                            int num_bits,
                            const std::filesystem::path& path) {
  const std::uint32_t largest = (1u << num_bits) - 1;
  Image<std::uint8_t> bytes{image.width, image.height, image.num_channels, {}};
  bytes.pixels.reserve(image.pixels.size());
  for (const std::uint32_t value : image.pixels) {
    if (value > largest) {
      throw DataError(
          "{}: a value is {}, more than picture_bits = {} bits hold: raise picture_bits "
          "of its [[camera]]",
          path.string(),
          value,
          num_bits);
    }
    bytes.pixels.push_back(static_cast<std::uint8_t>((255 * value + largest / 2) / largest));
  }
  return bytes;
}

}  // namespace nightmap
