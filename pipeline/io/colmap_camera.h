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
  if (!camera.HasDistortion()) return colmap;
  const auto& c = camera;
  std::vector<double> distortion = {c.k1, c.k2, c.k3, c.k4};
  if (c.lens == Lens::kFisheye) {
    colmap.model = "OPENCV_FISHEYE";
    colmap.model_id = 5;
  } else {
    colmap.model = "FULL_OPENCV";
    colmap.model_id = 6;
    distortion = {c.k1, c.k2, c.p1, c.p2, c.k3, c.k4, c.k5, c.k6};
  }
  colmap.parameters.insert(colmap.parameters.end(), distortion.begin(), distortion.end());
  return colmap;
}

}  // namespace nightmap
