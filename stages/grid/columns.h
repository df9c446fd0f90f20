// SPDX-License-Identifier: Apache-2.0
// What the octree holds above each cell of the grid. Heights are z in the map frame, counted in
// smallest voxels: voxel k spans [k, k + 1) * resolution.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "pipeline/base/progress.h"
#include "pipeline/io/octree_io.h"

namespace nightmap {

struct HeightRange {
  int min = 0;
  int max = 0;  // inclusive

  int Overlap(int first, int count) const {
    return std::max(0, std::min(max, first + count - 1) - std::max(min, first) + 1);
  }
};

struct Band {
  HeightRange floor;  // centres nearer to z = 0 than the band's lower end
  HeightRange obstacles;
  HeightRange free;  // where a robot needs space: from the floor to the band's upper end
};

// Voxels belong to a range by their centre. Throws UsageError when the band holds no centre.
Band MakeBand(double min_height_m, double max_height_m, double resolution_m);

struct Column {
  std::uint16_t num_occupied = 0;  // in the obstacle band
  std::uint16_t num_free = 0;      // in Band::free, as are the next two
  int lowest_free = std::numeric_limits<int>::max();
  int highest_free = -1;
  bool floor = false;

  // Voxels between free ones that no ray reached or crossed.
  int NumUnseen() const {
    return highest_free < 0 ? 0 : highest_free - lowest_free + 1 - num_free - num_occupied;
  }
};

struct Area {
  int min_x = 0, min_y = 0;  // cells from the map's origin
  int width = 0, height = 0;
};

struct Columns {
  Area area;
  std::vector<Column> columns;  // row by row, smallest y first

  std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(area.width) +
           static_cast<std::size_t>(x);
  }
};

// Throws DataError when no leaf lies in the band's ranges or the area is too large.
Columns CollectColumns(const OccupancyTree& tree, const Band& band, Progress& progress);

}  // namespace nightmap
