// SPDX-License-Identifier: Apache-2.0
// Points of a plane, sorted into square cells, to find those near a place.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace nightmap {

// Immutable and safe to share between threads. Takes 32 bytes per point.
class PlaneGrid {
 public:
  // Points are finite. A search is fast when its radius is a few cells.
  PlaneGrid(const std::vector<Eigen::Vector2d>& points, double cell_m);

  // The indices, ascending, of all points at most radius_m away; `radius_m` may be infinite.
  std::vector<std::size_t> Near(const Eigen::Vector2d& place, double radius_m) const;

 private:
  struct Entry {
    double column = 0, row = 0;  // of the cell; whole numbers
    std::size_t idx = 0;
  };

  double Cell(double coordinate_m) const;

  double cell_m_;
  std::vector<Eigen::Vector2d> points_;
  std::vector<Entry> entries_;  // by column, row, index
};

}  // namespace nightmap
