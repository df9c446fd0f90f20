// SPDX-License-Identifier: Apache-2.0
// The octree's content above each cell of the grid, as runs along z. Heights are z in the map
// frame, counted in smallest voxels: voxel k spans [k, k + 1) * resolution.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/base/progress.h"
#include "pipeline/dense/octree_leaves.h"

namespace nightmap {

struct HeightRange {
  int min = 0;
  int max = 0;  // inclusive; below min: empty

  int Overlap(int begin, int end) const {
    return std::max(0, std::min(max + 1, end) - std::max(min, begin));
  }
};

// The voxels whose centres lie in [min_m, max_m].
HeightRange VoxelsWithin(double min_m, double max_m, double resolution_m);

// Voxels [begin, end) of one state.
struct ColumnRun {
  std::int32_t begin = 0;
  std::int32_t end = 0;
  bool occupied = false;
};

struct Area {
  int min_x = 0, min_y = 0;  // in cells, from the map's origin
  int width = 0, height = 0;

  std::size_t Size() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
  std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
};

struct Columns {
  Area area;
  double resolution_m = 0;
  // Index of each column's first run, row by row, smallest y first; then the end.
  std::vector<std::size_t> first;
  std::vector<ColumnRun> runs;  // of each column upwards; adjacent voxels of one state form one run

  std::span<const ColumnRun> Of(std::size_t column) const {
    return {runs.data() + first[column], runs.data() + first[column + 1]};
  }
};

// Reads the leaves three times and holds only the columns, so a tree need not fit into memory.
// Throws DataError when there is no leaf or the leaves span too large an area.
Columns CollectColumns(const LeafSource& leaves, Progress& progress);

}  // namespace nightmap
