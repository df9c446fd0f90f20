// SPDX-License-Identifier: Apache-2.0
// Resizes pictures, and computes the camera that would have taken them.
#pragma once

#include "pipeline/geometry/camera.h"
#include "pipeline/io/image_io.h"

namespace nightmap {

struct CameraPicture {
  ColorImage color;
  Camera camera;
};

// The same lens before a sensor with fewer (or more) pixels. A ray through pixel (x, y) goes
// through ((x + 0.5) * scale - 0.5, ...), because pixel (0, 0) is the centre of the top left one.
// Distortion applies to rays and stays.
Camera ResizeCamera(const Camera& camera, int width, int height);

// Where the pixel lies in a picture of `to` that was resized from one of `from`.
Eigen::Vector2d ResizePixel(const Eigen::Vector2d& pixel, const Camera& from, const Camera& to);

// Scales down by `scale` (at most 1), to whole pixels and at least one. Each pixel is the mean of
// the area that it covers. Deterministic.
CameraPicture ShrinkPicture(const ColorImage& color, const Camera& camera, double scale);
// Likewise to this size.
ColorImage ShrinkColor(const ColorImage& color, int width, int height);

// Each pixel has the value of the one that lies at its centre: for depth and classes, whose mean is
// none. Returns an image of that size unchanged.
template <typename T>
Image<T> SampleImage(Image<T> image, int width, int height) {
  if (image.width == width && image.height == height) return image;
  Image<T> sampled{width, height, 1, {}};
  sampled.pixels.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y) {
    const int row = (2 * y + 1) * image.height / (2 * height);
    for (int x = 0; x < width; ++x) {
      sampled.pixels.push_back(image.At((2 * x + 1) * image.width / (2 * width), row));
    }
  }
  return sampled;
}

}  // namespace nightmap
