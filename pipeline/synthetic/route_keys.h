// SPDX-License-Identifier: Apache-2.0
// The corners of the robot's drive before smoothing.
#pragma once

#include <vector>

#include "pipeline/synthetic/route.h"

namespace nightmap {

// Polyline of all laps with the heading at each key; starts in the middle of the west corridor,
// driving south, then counter-clockwise. The last key has the first one's position. Every room is
// visited once a lap; laps differ by a small lateral offset. Of two floors the lower one is driven
// first, then the ramp up, the upper floor, and the ramp down.
std::vector<RoutePoint> RouteKeys(const FloorLayout& layout, const RouteOptions& options);

}  // namespace nightmap
