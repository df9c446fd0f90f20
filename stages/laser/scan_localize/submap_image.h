// SPDX-License-Identifier: Apache-2.0
// Scans and maps as pictures of three values, which a template is matched on.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "pipeline/geometry/rigid2.h"
#include "pipeline/io/grid_io.h"
#include "pipeline/io/image_io.h"
#include "pipeline/laser/scan_queries_io.h"

namespace nightmap {

// Non-free is what no beam reached, and unknown cells of a map.
enum SubmapPixel : std::uint8_t { kBoundaryPixel = 0, kNonFreePixel = 128, kFreePixel = 255 };

// Pixel (column, row) has its lower left corner at origin + resolution * (column, row), along the
// axes of the map.
struct SubmapImage {
  GrayImage image;
  double resolution_m = 0;
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  // of pixel (0, 0), m

  Eigen::Vector2i PixelOf(const Eigen::Vector2d& point) const {
    return ((point - origin) / resolution_m).array().floor().cast<int>();
  }
};

// The scans of a query, turned by the heading: the robot is at the origin, in the middle of a
// pixel. Beams are cut at max_range_m, where they have no boundary.
SubmapImage ImageOfSubmap(const ScanQuery& query,
                          double heading_rad,
                          double resolution_m,
                          double max_range_m);

// The part of the map from `low` to `high`, in m in the map; outside of the grid it is non-free. A
// pixel is boundary if any cell in it is occupied, else free if any is free.
SubmapImage ImageOfMap(const OccupancyGrid& grid,
                       double resolution_m,
                       const Eigen::Vector2d& low,
                       const Eigen::Vector2d& high);

}  // namespace nightmap
