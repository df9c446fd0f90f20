// SPDX-License-Identifier: Apache-2.0
// Harris corners of one scale, to a fraction of a pixel, with the orientation of their surroundings
// (Harris and Stephens, A combined corner and edge detector, AVC 1988; the orientation is that of
// ORB: Rublee et al., ICCV 2011).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/io/image_io.h"

namespace nightmap {

struct HarrisCorner {
  Eigen::Vector2f pixel = Eigen::Vector2f::Zero();
  float response = 0;   // det - k trace^2 of the structure tensor
  float angle_deg = 0;  // from x towards y, of the intensity centroid of the described patch
};

struct HarrisOptions {
  double min_gradient = 3;  // gray levels per pixel, of a corner as strong in all directions
  int max_per_cell = 12;    // of 8 x 6 cells of the picture
};

// Corners at least kHarrisBorder_px away from the border, where ORB's patch lies inside at any
// angle. Strongest first, ties by position. Each is a maximum among the pixels near it, refined to
// the point at which the gradients around it aim. Deterministic; one thread.
constexpr int kHarrisBorder_px = 20;
std::vector<HarrisCorner> FindHarrisCorners(const GrayImage& gray, const HarrisOptions& options);

}  // namespace nightmap
