// SPDX-License-Identifier: Apache-2.0
// Converts depth pixels to points, without those that depth cameras measure badly: flying pixels at
// the edges of objects, and surfaces seen at a grazing angle.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/io/frames_io.h"

namespace nightmap {

struct DepthFilterOptions {
  OPTION(int, pixel_stride, 2, {1, 16}, "uses every Nth pixel of every Nth row");
  OPTION(int, edge_radius_px, 2, {0, 16},
         "distance up to which neighbours are compared for edges; 0 keeps flying pixels");
  OPTION(double, max_incidence_rad, 1.4, {0.1, 1.5707963},
         "largest angle between viewing ray and surface normal");
  REGISTER_OPTIONS();
};

// Ray of each pixel, row by row, at z = 1 with the distortion removed.
using RayTable = std::vector<Eigen::Vector2f>;
RayTable MakeRayTable(const Camera& camera, int num_threads);
std::vector<RayTable> MakeRayTables(const std::vector<RgbdCamera>& cameras, int num_threads);

struct DepthPoint {
  Eigen::Vector3f point_in_camera;  // metres
  float sigma_m = 0;                // standard deviation of its depth
  std::array<std::uint8_t, 3> rgb{};
};

// The points of every pixel_stride-th pixel in row order. Leaves out a pixel when its depth is 0 or
// beyond max_depth_m, when its depth differs from that of a pixel up to edge_radius_px beside or
// above it by more than 4 % of the depth and three sigma of its noise, or when the camera sees the
// local surface at more than max_incidence_rad from its normal.
std::vector<DepthPoint> BackProjectDepth(const DepthImage& depth,
                                         const ColorImage& color,
                                         const RayTable& rays,
                                         const RgbdCamera& camera,
                                         double max_depth_m,
                                         const DepthFilterOptions& options);

}  // namespace nightmap
