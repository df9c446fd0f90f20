// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/mesh/surface_cells.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "pipeline/geometry/voxel_key.h"

namespace nightmap {
namespace {

using Keys = std::vector<std::uint64_t>;

// Each key moved by `first` to `last` steps along every axis.
Keys Spread(Keys keys, int first, int last) {
  const std::uint64_t origin = PackVoxel(VoxelKey::Zero());
  for (const VoxelKey& axis : {VoxelKey(0, 0, 1), VoxelKey(0, 1, 0), VoxelKey(1, 0, 0)}) {
    Keys all, united;
    for (int step = first; step <= last; ++step) {
      const std::uint64_t shift = PackVoxel(step * axis) - origin;  // modulo 2^64
      Keys moved = keys;
      for (std::uint64_t& key : moved) key += shift;
      united.clear();
      std::ranges::set_union(all, moved, std::back_inserter(united));
      all.swap(united);
    }
    keys = std::move(all);
  }
  return keys;
}

}  // namespace

bool IsCellOf(const Rectangle& tile, std::uint64_t key, double cell_size_m) {
  return tile.Contains(UnpackVoxel(key).head<2>().cast<double>() * cell_size_m);
}

Keys CellsNear(const std::vector<CloudPoint>& points,
               const Rectangle& tile,
               double cell_size_m,
               double max_gap_m) {
  Keys cells;
  cells.reserve(points.size());
  for (const CloudPoint& point : points) {
    cells.push_back(PackVoxel(VoxelOf(point.position_in_map.cast<double>(), cell_size_m)));
  }
  std::ranges::sort(cells);
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  const int num_cells = static_cast<int>(std::ceil(max_gap_m / cell_size_m));
  cells = Spread(std::move(cells), -num_cells, num_cells);
  std::erase_if(cells, [&](std::uint64_t cell) { return !IsCellOf(tile, cell, cell_size_m); });
  return cells;
}

Keys CornersOf(const Keys& cells) { return Spread(cells, 0, 1); }

}  // namespace nightmap
