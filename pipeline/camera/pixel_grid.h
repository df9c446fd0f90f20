// SPDX-License-Identifier: Apache-2.0
// Buckets of pixels for search within a fixed radius.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "pipeline/geometry/camera.h"

namespace nightmap {

// Cells are as wide as the search radius, so a 3 x 3 block of cells covers it. Values are visited
// in the order of cells, then of insertion.
class PixelGrid {
 public:
  // Pixels outside the image of `camera` (possible for undistorted keypoints) belong to its border
  // cells.
  PixelGrid(const Camera& camera, double radius_px)
      : cell_px_(radius_px),
        columns_(Cell(camera.width) + 3),
        rows_(Cell(camera.height) + 3),
        cells_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {}

  void Add(const Eigen::Vector2d& pixel, int value) {
    cells_[Index(Column(pixel), Row(pixel))].push_back(value);
  }

  // Calls body(value) for every value that may lie within the radius, and for some that do not.
  template <typename Body>
  void ForNear(const Eigen::Vector2d& pixel, const Body& body) const {
    const int column = Column(pixel);
    const int row = Row(pixel);
    for (int y = row - 1; y <= row + 1; ++y) {
      for (int x = column - 1; x <= column + 1; ++x) {
        for (const int value : cells_[Index(x, y)]) body(value);
      }
    }
  }

 private:
  int Cell(double coordinate) const { return static_cast<int>(std::floor(coordinate / cell_px_)); }
  // Clamps before conversion to an integer; NaN goes to the first cell.
  int Clamped(double coordinate, int count) const {
    const double cell = std::floor(coordinate / cell_px_) + 1;
    return cell > 1 ? static_cast<int>(std::min(cell, static_cast<double>(count - 2))) : 1;
  }
  int Column(const Eigen::Vector2d& pixel) const { return Clamped(pixel.x(), columns_); }
  int Row(const Eigen::Vector2d& pixel) const { return Clamped(pixel.y(), rows_); }
  std::size_t Index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }

  double cell_px_;
  int columns_;
  int rows_;
  std::vector<std::vector<int>> cells_;
};

}  // namespace nightmap
