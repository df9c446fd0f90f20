// SPDX-License-Identifier: Apache-2.0
// Marching cubes over some cells of a grid.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/geometry/voxel_key.h"

namespace nightmap {

// Cells are named by their lower corner. Keys are packed (PackVoxel) and ascend; corners are all
// those of the cells.
struct SampledGrid {
  double cell_size_m = 0;
  std::vector<std::uint64_t> cells;
  std::vector<std::uint64_t> corners;
  std::vector<double> distances_m;  // from the surface, at the corners; negative behind it, or NaN
};

// The edge from a corner of the grid, the index of which it is, along an axis: 3 * corner + axis.
using EdgeId = std::uint64_t;

// The edges on which the vertices of a triangle lie, counterclockwise from the front.
using EdgeTriangle = std::array<EdgeId, 3>;

// Adds this to a packed key to move it.
inline std::uint64_t ShiftOf(int x, int y, int z) {
  return PackVoxel({x, y, z}) - PackVoxel(VoxelKey::Zero());
}

// The triangles of the cells with a distance at all corners, in the order of the cells.
std::vector<EdgeTriangle> MarchCubes(const SampledGrid& grid, int num_threads);

}  // namespace nightmap
