// SPDX-License-Identifier: Apache-2.0
// The true 2-D plan of the building, computed from its geometry.
#pragma once

#include "pipeline/io/grid_io.h"
#include "pipeline/synthetic/synthetic_world.h"

namespace nightmap {

// A cell is occupied where any box that reaches into the height band overlaps it, however little;
// free where it is indoors and not occupied; unknown outside of the building.
OccupancyGrid TrueFloorPlan(const SyntheticWorld& world, const FloorPlanOptions& options);

}  // namespace nightmap
