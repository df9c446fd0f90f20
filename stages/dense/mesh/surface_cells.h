// SPDX-License-Identifier: Apache-2.0
// Cells of a regular grid near points, and their corners. Cells are named by their lower corner;
// all lists hold packed keys (PackVoxel), ascending.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/dense/ply_io.h"
#include "pipeline/geometry/rectangle.h"

namespace nightmap {

// Whether a cell's lower corner lies in the rectangle; key is packed.
bool IsCellOf(const Rectangle& tile, std::uint64_t key, double cell_size_m);

// The cells of `tile` that may hold a place within max_gap_m of a point.
std::vector<std::uint64_t> CellsNear(const std::vector<CloudPoint>& points,
                                     const Rectangle& tile,
                                     double cell_size_m,
                                     double max_gap_m);

// All corners of the cells.
std::vector<std::uint64_t> CornersOf(const std::vector<std::uint64_t>& cells);

}  // namespace nightmap
