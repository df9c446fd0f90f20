// SPDX-License-Identifier: Apache-2.0
// A repeating color texture with a mip pyramid, so that its appearance is stable between views.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "pipeline/io/image_io.h"

namespace nightmap {

class Texture {
 public:
  // `image` is RGB; its width and height are powers of two (else UsageError). Levels are 2x2 means.
  explicit Texture(const ColorImage& image);

  struct Level {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> rgbx;  // four bytes per texel, in blocks of texels
  };
  // The two levels of the pyramid that a filter blends. Lives no longer than the texture.
  struct Filter {
    const Level* fine = nullptr;
    const Level* coarse = nullptr;
    float blend = 0;       // weight of the coarse one
    Eigen::Array4f sizes;  // width and height of both
  };
  // `footprint` is the width of the filter as a fraction of one repeat.
  Filter FilterOf(float footprint) const;

  // Color in [0, 255] and 0 as the fourth, trilinear. `uv` counts repeats (any real number).
  static Eigen::Vector4f Sample(const Eigen::Vector2f& uv, const Filter& filter);

 private:
  static Level Halve(const Level& fine);

  std::vector<Level> levels_;
};

}  // namespace nightmap
