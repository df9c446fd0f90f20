// SPDX-License-Identifier: Apache-2.0
// Whether a path lies on the grid that it is to be driven on.
#pragma once

#include "pipeline/io/grid_io.h"
#include "pipeline/io/path_io.h"

namespace nightmap {

// Throws DataError naming the path's file, line and place, and the grid's extent, at the first
// point that is not in a cell of the grid.
void CheckOnGrid(const PlannedPath& path, const OccupancyGrid& grid);

}  // namespace nightmap
