// SPDX-License-Identifier: Apache-2.0
// Resizes a picture, and computes the camera that would have taken it.
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

// Scales down by `scale` (at most 1), to whole pixels and at least one. Each pixel is the mean of
// the area that it covers. Deterministic.
CameraPicture ShrinkPicture(const ColorImage& color, const Camera& camera, double scale);

}  // namespace nightmap
