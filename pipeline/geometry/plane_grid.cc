// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/plane_grid.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace nightmap {

PlaneGrid::PlaneGrid(const std::vector<Eigen::Vector2d>& points, double cell_m)
    : cell_m_(cell_m), points_(points) {
  entries_.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    entries_.push_back({Cell(points[i].x()), Cell(points[i].y()), i});
  }
  std::ranges::sort(entries_, {}, [](const Entry& entry) {
    return std::tuple(entry.column, entry.row, entry.idx);
  });
}

double PlaneGrid::Cell(double coordinate_m) const { return std::floor(coordinate_m / cell_m_); }

std::vector<std::size_t> PlaneGrid::Near(const Eigen::Vector2d& place, double radius_m) const {
  const double last_column = Cell(place.x() + radius_m), last_row = Cell(place.y() + radius_m);
  const double first_column = Cell(place.x() - radius_m), first_row = Cell(place.y() - radius_m);
  const auto cell_of = [](const Entry& entry) { return std::pair(entry.column, entry.row); };
  std::vector<std::size_t> near;
  auto entry = entries_.begin();
  const auto go_to = [&](double column, double row) {
    entry = std::ranges::lower_bound(entry, entries_.end(), std::pair(column, row), {}, cell_of);
  };
  go_to(first_column, first_row);
  while (entry != entries_.end() && entry->column <= last_column) {
    const double column = entry->column;
    if (entry->row < first_row) go_to(column, first_row);
    for (; entry != entries_.end() && entry->column == column && entry->row <= last_row; ++entry) {
      if ((points_[entry->idx] - place).norm() <= radius_m) near.push_back(entry->idx);
    }
    if (entry != entries_.end() && entry->column == column) go_to(column + 1, first_row);
  }
  std::ranges::sort(near);
  return near;
}

}  // namespace nightmap
