// SPDX-License-Identifier: Apache-2.0
// Whether a path and a grid belong together.
#pragma once

#include "pipeline/io/grid_io.h"
#include "pipeline/io/path_io.h"

namespace nightmap {

// Throws DataError when a point of the path is not on the grid's rectangle (to the micrometres of
// path.csv); the message names the file, the point, the grid's extent and the remedy.
void CheckOnGrid(const PlannedPath& path, const OccupancyGrid& grid);

}  // namespace nightmap
