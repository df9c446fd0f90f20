// SPDX-License-Identifier: Apache-2.0
// A picture of another size, and the camera that would have taken it.
#pragma once

#include "pipeline/geometry/camera.h"
#include "pipeline/io/image_io.h"

namespace nightmap {

struct CameraPicture {
  ColorImage color;
  Camera camera;
};

// The same lens before a sensor of fewer (or more) pixels: a ray through pixel (x, y) goes through
// ((x + 0.5) * scale - 0.5, ...), as pixel (0, 0) is the centre of the top left one. Distortion is
// of rays and stays.
Camera ResizeCamera(const Camera& camera, int width, int height);

// Scaled down by `scale` (at most 1), to whole pixels and at least one: each pixel is the mean of
// the area it covers. Deterministic.
CameraPicture ShrinkPicture(const ColorImage& color, const Camera& camera, double scale);

}  // namespace nightmap
