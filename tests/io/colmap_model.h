// SPDX-License-Identifier: Apache-2.0
// A small COLMAP model.
#pragma once

#include "pipeline/io/colmap_io.h"

namespace nightmap {

// Two cameras, one distorted; two images that see three points, the first image one alone.
inline ColmapModel MakeColmapModelOfTwo() {
  ColmapModel model;
  model.cameras = {{640, 480, 500, 501, 319.5, 239.5}, {32, 24, 30, 31, 15.5, 11.5}};
  model.cameras[1].k1 = 0.25;
  model.cameras[1].k2 = -0.5;
  model.cameras[1].p1 = 0.125;
  model.cameras[1].p2 = 0.0625;
  model.cameras[1].k3 = 2;
  const Rigid3 half_turn{Eigen::Quaterniond(0, 0, 1, 0), {1, 2, 3}};
  model.images.push_back({"a/1.png", 0, {}});
  model.images.push_back({"a/2.png", 1, half_turn});
  model.features = [](std::size_t i) {
    return i == 0
               ? ColmapFeatures{{{0, 0}, {10, 20.25}}, std::vector<std::uint8_t>(2 * 128, 7)}
               : ColmapFeatures{{{5, 6}, {7, 8}, {9, 10}}, std::vector<std::uint8_t>(3 * 128, 9)};
  };
  model.AddPoint({0.5, 1, 2}, 0.75, {{0, 1}});
  model.AddPoint({-1, 0, 4}, 0.25, {{0, 0}, {1, 2}});
  return model;
}

}  // namespace nightmap
