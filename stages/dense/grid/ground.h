// SPDX-License-Identifier: Apache-2.0
// Height of the ground in each cell of a floor: the floor's height or, on ramps, the ramp's.
#pragma once

#include <vector>

#include "stages/dense/grid/floors.h"

namespace nightmap {

// Supports within a step of the floor's height are level ground. From there the ground follows the
// supports from cell to cell (4 neighbours) while they differ by at most a step, up or down to
// within a step of the next floor. Patches smaller than min_ramp_area_m2 are no ramps. A ramp that
// joins two floors thus belongs to both.
//
// A ramp continues behind up to 1.5 m of unseen ground below seen free space, if a slope of 0.36 or
// less leads there. Cells without a support take their ground from the supports within 0.75 m and
// are level beyond. Ground that rose by more than a step and a slope of 0.36 since level ground is
// no ramp but stacked objects, such as cushions in front of a table.
//
// `floors_m` comes from FindFloors. Returns z (m) of each cell.
std::vector<double> FindGround(const GridOptions& options,
                               const Columns& columns,
                               const Supports& supports,
                               const std::vector<double>& floors_m,
                               std::size_t floor_idx);

}  // namespace nightmap
