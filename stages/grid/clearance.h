// SPDX-License-Identifier: Apache-2.0
// Distance maps of a grid, centre to centre, by the exact Euclidean distance transform. Row by row
// as the grid's cells. The same at any number of threads.
#pragma once

#include <vector>

#include "pipeline/io/grid_io.h"

namespace nightmap {

// From a free cell to the nearest cell that is not free, the outside of the grid included; 0 in
// cells that are not free. A round robot clears a place where this is at least its radius.
std::vector<float> Clearance_m(const OccupancyGrid& grid, int num_threads);

// To the nearest occupied cell; in occupied cells to the nearest one that is not, negative. Zero
// lies midway between the centres on both sides of an edge. Unknown cells are no obstacles here.
// With no cell of the other kind the distance is at least the grid's width.
std::vector<float> SignedDistance_m(const OccupancyGrid& grid, int num_threads);

}  // namespace nightmap
