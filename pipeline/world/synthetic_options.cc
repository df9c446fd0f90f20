// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/synthetic_options.h"

namespace nightmap {

Camera CenteredPinhole(int width_px, int height_px, double focal_length_px) {
  Camera camera;
  camera.width = width_px;
  camera.height = height_px;
  camera.fx = camera.fy = focal_length_px;
  camera.cx = 0.5 * (width_px - 1);
  camera.cy = 0.5 * (height_px - 1);
  return camera;
}

}  // namespace nightmap
