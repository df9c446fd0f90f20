// SPDX-License-Identifier: Apache-2.0
// The true 2-D plan of the building, computed from its geometry.
#pragma once

#include "pipeline/io/grid_io.h"
#include "pipeline/world/synthetic_world.h"

namespace nightmap {

// The plan of one floor (0 is the lowest). A cell is occupied where any box that reaches into the
// height band above the floor overlaps it, however little. It is free where it is indoors and not
// occupied, and unknown outside the building. The ramp between two floors is free on both, except
// for the end within the band's lower limit of the other floor: on the upper floor that end is
// occupied, because the floor has an edge there; on the lower floor it is unknown, because it is
// out of sight below the ramp.
OccupancyGrid TrueFloorPlan(const SyntheticWorld& world,
                            const FloorPlanOptions& options,
                            int floor = 0);

}  // namespace nightmap
