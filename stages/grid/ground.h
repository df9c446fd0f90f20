// SPDX-License-Identifier: Apache-2.0
// How high the ground is in each cell of a floor: the floor's height, and along ramps the ramp's.
#pragma once

#include <vector>

#include "stages/grid/floors.h"

namespace nightmap {

// What lies within a step of the floor's height is level ground. From there on the ground follows
// the supports from cell to cell (4 neighbours) as long as they differ by a step at most, up or
// down to within a step of the next floor; patches of less than min_ramp_area_m2 are no ramps. So
// both floors have the ramp that joins them. A ramp goes on behind up to 1.5 m of ground that was
// not seen below seen free space, if it can have got there at a slope of 0.36. Cells without a
// support take their ground from the supports around them, up to 0.75 m off, and are level beyond.
// What has risen by more than a step and a slope of 0.36 since level ground is no ramp but things
// on each other, cushions before a table, say. `floors_m` as of FindFloors. Returns z (m) of each
// cell.
std::vector<double> FindGround(const GridOptions& options,
                               const Columns& columns,
                               const Supports& supports,
                               const std::vector<double>& floors_m,
                               std::size_t floor_idx);

}  // namespace nightmap
