// SPDX-License-Identifier: Apache-2.0
// Checks that a path lies on the grid on which it is to be driven.
#pragma once

#include "pipeline/io/grid_io.h"
#include "pipeline/plan/path_io.h"

namespace nightmap {

// Throws InputError at the first point outside the grid's cells. The message names the line of the
// path's file, the place, and the grid's extent.
void CheckOnGrid(const PlannedPath& path, const OccupancyGrid& grid);

}  // namespace nightmap
