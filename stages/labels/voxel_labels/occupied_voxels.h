// SPDX-License-Identifier: Apache-2.0
// The voxels of a tile that labels are for.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "pipeline/geometry/rectangle.h"

namespace nightmap {

// Occupied voxels of the smallest size, by their MortonCode, ascending.
struct OccupiedVoxels {
  double resolution_m = 0;
  std::vector<std::uint64_t> own;    // of the tile, which get labels
  std::vector<std::uint64_t> codes;  // these, and those beside the tile, whose votes spread to them
};

// The tile's octree, and those of it and its neighbours, of which it takes what lies within
// `around`. Throws DataError as OctreeReader, and when a leaf is larger than `around`, as none of a
// tile is: it would be taken apart to more voxels than a tile has.
OccupiedVoxels ReadOccupiedVoxels(const std::filesystem::path& own,
                                  const std::vector<std::filesystem::path>& near,
                                  const Rectangle& around);

}  // namespace nightmap
