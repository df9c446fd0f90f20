// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/point_cloud/radius_neighbors.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/parallel.h"
#include "pipeline/geometry/voxel_key.h"

namespace nightmap {
namespace {

// Points above one another, in voxels that share x and y.
struct Column {
  int x = 0;
  int y = 0;
  std::size_t begin = 0;
  std::size_t end = 0;
};

std::vector<Column> MakeColumns(const std::vector<std::uint64_t>& voxels) {
  std::vector<Column> columns;
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const VoxelKey key = UnpackVoxel(voxels[i]);
    if (columns.empty() || key.x() != columns.back().x || key.y() != columns.back().y) {
      columns.push_back({key.x(), key.y(), i, i});
    }
    ++columns.back().end;
  }
  return columns;
}

// A nearby column, and the range [begin, end) of its points that may be neighbours of the current
// point.
struct Window {
  std::size_t begin = 0;
  std::size_t end = 0;
  std::size_t column_end = 0;
};

std::vector<Window> ColumnsAround(const std::vector<Column>& columns,
                                  const Column& centre,
                                  int reach) {
  std::vector<Window> windows;
  for (int x = centre.x - reach; x <= centre.x + reach; ++x) {
    const auto before = [x](const Column& column, int y) {
      return column.x != x ? column.x < x : column.y < y;
    };
    auto column = std::lower_bound(columns.begin(), columns.end(), centre.y - reach, before);
    for (; column != columns.end() && column->x == x && column->y <= centre.y + reach; ++column) {
      windows.push_back({column->begin, column->begin, column->end});
    }
  }
  return windows;
}

// The points of a column ascend, so windows only move up.
void MoveWindow(const std::vector<Eigen::Vector3d>& points,
                double lowest_m,
                double highest_m,
                Window& window) {
  while (window.end < window.column_end && points[window.end].z() <= highest_m) ++window.end;
  while (window.begin < window.end && points[window.begin].z() < lowest_m) ++window.begin;
}

}  // namespace

void ForEachNeighborhood(
    const std::vector<std::uint64_t>& voxels,
    const std::vector<Eigen::Vector3d>& points,
    double voxel_size_m,
    double radius_m,
    int num_threads,
    const std::function<void(std::size_t, const std::vector<Neighbor>&)>& body) {
  const std::vector<Column> columns = MakeColumns(voxels);
  const int reach = static_cast<int>(std::ceil(radius_m / voxel_size_m));
  ParallelFor(columns.size(), num_threads, [&](std::size_t c) {
    std::vector<Window> windows = ColumnsAround(columns, columns[c], reach);
    std::vector<Neighbor> neighbors;
    for (std::size_t i = columns[c].begin; i < columns[c].end; ++i) {
      neighbors.clear();
      for (Window& window : windows) {
        MoveWindow(points, points[i].z() - radius_m, points[i].z() + radius_m, window);
        for (std::size_t j = window.begin; j < window.end; ++j) {
          const double squared_m2 = (points[j] - points[i]).squaredNorm();
          if (squared_m2 < radius_m * radius_m) neighbors.push_back({j, squared_m2});
        }
      }
      body(i, neighbors);
    }
  });
}

}  // namespace nightmap
