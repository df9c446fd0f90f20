// SPDX-License-Identifier: Apache-2.0
// Says and shows why there is no path.
#pragma once

#include "pipeline/io/grid_io.h"
#include "pipeline/io/image_io.h"
#include "stages/plan/plan/cost_map.h"
#include "stages/plan/plan/endpoints.h"
#include "stages/plan/plan/plan.h"

namespace nightmap {

// Throws the DataError of two ends that do not reach each other: how far each gets, and which robot
// would pass, or that none would.
[[noreturn]] void FailUnreachable(const OccupancyGrid& grid,
                                  const CostMap& map,
                                  const CostOptions& options,
                                  const Endpoint& start,
                                  const Endpoint& goal);

// Draws the floor's grid for which RunPlan threw a DataError: where the robot's centre can get to
// from the start (green), from each goal (red) and otherwise (blue), the ends as asked for with the
// circles of snap_radius_m that they may be moved in (at the border when they are outside), and,
// between ends that do not reach each other, where the widest way is too narrow. Throws as
// MakeRequests does when there are no ends.
ColorImage DrawNoPath(const PlanOptions& options, const PlanInputs& inputs, int num_threads);

}  // namespace nightmap
