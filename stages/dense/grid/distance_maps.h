// SPDX-License-Identifier: Apache-2.0
// Distance maps of a grid, between cell centres, by the exact Euclidean distance transform. Row by
// row like the grid's cells. The same at any number of threads.
#pragma once

#include <vector>

#include "pipeline/io/grid_io.h"

namespace nightmap {

// Distance from a free cell to the nearest cell that is not free; outside the grid counts as not
// free. 0 in cells that are not free. A round robot fits where this is at least its radius.
std::vector<float> Clearance_m(const OccupancyGrid& grid, int num_threads);

// Distance to the nearest occupied cell; in occupied cells the negative distance to the nearest
// cell that is not occupied. Zero lies midway between the centres on both sides of an edge. Unknown
// cells are no obstacles here. With no cell of the other kind the distance is at least the grid's
// width.
std::vector<float> SignedDistance_m(const OccupancyGrid& grid, int num_threads);

}  // namespace nightmap
