// SPDX-License-Identifier: Apache-2.0
// The corners of the robot's drive before smoothing.
#pragma once

#include <vector>

#include "pipeline/world/route.h"

namespace nightmap {

// Polyline of all laps with the heading at each key. It starts in the middle of the west corridor,
// driving south, then counter-clockwise. The last key has the first one's position. Every lap
// visits every room; laps differ by a small lateral offset. With two floors it drives the lower
// floor, the ramp up, the upper floor, and the ramp down.
std::vector<RoutePoint> RouteKeys(const FloorLayout& layout, const RouteOptions& options);

}  // namespace nightmap
