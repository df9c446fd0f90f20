// SPDX-License-Identifier: Apache-2.0
// Draws walls one cell wide: the noise of ranges and poses spreads the hits on a wall over cells
// before and behind it.
#pragma once

#include <cstdint>
#include <span>

#include "pipeline/io/grid_io.h"

namespace nightmap {

// An occupied cell of a straight piece of wall stays only if no neighbour across the wall exceeds
// it in hits (non-maximum suppression: Canny, A computational approach to edge detection, PAMI
// 1986). The wall's direction is the principal axis of the hits within 4 cells; corners, posts and
// clutter, whose hits have no direction, stay as they are. A cell that goes becomes free where
// free space begins on its other side, else unknown: what lies behind a wall was not seen. `hits`
// is by cell of the grid. Pure.
void ThinWalls(std::span<const std::uint32_t> hits, OccupancyGrid* grid);

}  // namespace nightmap
