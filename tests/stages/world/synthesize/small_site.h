// SPDX-License-Identifier: Apache-2.0
// A small building and camera, for tests of what is recorded there.
#pragma once

#include "stages/world/synthesize/synthesize.h"

namespace nightmap {

inline SynthesizeOptions SmallSite() {
  SynthesizeOptions options;
  options.building.num_rooms = 3;
  options.building.light_map_cell_m = 0.6;
  options.building.num_light_samples = 2;
  options.camera.image_width_px = 64;
  options.camera.image_height_px = 48;
  options.camera.focal_length_px = 52;
  options.route.num_frames = 450;
  options.queries.num_queries = 5;
  return options;
}

}  // namespace nightmap
