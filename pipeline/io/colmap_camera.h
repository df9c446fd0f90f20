// SPDX-License-Identifier: Apache-2.0
// A camera and its pixels in COLMAP's conventions, for the writers of colmap_io.h.
#pragma once

#include <string>
#include <vector>

#include "pipeline/geometry/camera.h"

namespace nightmap {

struct ColmapCamera {
  std::string model;
  int model_id = 0;
  int width = 0;
  int height = 0;
  std::vector<double> parameters;
};

inline Eigen::Vector2d ToColmapPixel(const Eigen::Vector2d& pixel) {
  return pixel + Eigen::Vector2d(0.5, 0.5);
}

inline ColmapCamera ToColmap(const Camera& camera) {
  const Eigen::Vector2d centre = ToColmapPixel({camera.cx, camera.cy});
  ColmapCamera colmap{"PINHOLE", 1, camera.width, camera.height, {}};
  colmap.parameters = {camera.fx, camera.fy, centre.x(), centre.y()};
  if (camera.HasDistortion()) {
    colmap.model = "FULL_OPENCV";
    colmap.model_id = 6;
    // k4 k5 k6 of the rational model follow.
    const auto distortion = {camera.k1, camera.k2, camera.p1, camera.p2, camera.k3, 0.0, 0.0, 0.0};
    colmap.parameters.insert(colmap.parameters.end(), distortion);
  }
  return colmap;
}

}  // namespace nightmap
