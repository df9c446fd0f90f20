// SPDX-License-Identifier: Apache-2.0
// Makes the values of a color picture those that the pipeline computes with: three channels of 8
// bits.
#pragma once

#include <filesystem>

#include "pipeline/io/image_io.h"

namespace nightmap {

// Gray (+ alpha) to three equal channels, RGB + alpha to RGB.
ColorImage ToRgb(const Image<std::uint8_t>& image);

// The `num_bits` (9 .. 16) in use, scaled to 8 and rounded: equal values of two pictures stay
// equal, whatever else is in them. Throws DataError naming the file when a value needs more bits.
Image<std::uint8_t> ToBytes(const Image<std::uint16_t>& image,
                            int num_bits,
                            const std::filesystem::path& path);

}  // namespace nightmap
