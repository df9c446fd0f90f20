// SPDX-License-Identifier: Apache-2.0
// Narrow holes in the seen floor: cells that no ray told anything of, with free cells all around.
#pragma once

#include <cstddef>
#include <vector>

#include "pipeline/io/grid_io.h"

namespace nightmap {

// Indices of the cells of all holes, in rising order. A hole is a part of unknown cells (8
// neighbours) whose neighbours are all free and in which no square wider than `max_width_m` fits:
// what stands in it would be thin and seen from nowhere. A part that touches the grid's border or
// an occupied cell is none. Widths count up to 250 cells. Linear time; deterministic.
std::vector<std::size_t> FindUnknownHoles(const OccupancyGrid& grid, double max_width_m);

// The grid with some cells free.
OccupancyGrid WithCellsFree(OccupancyGrid grid, const std::vector<std::size_t>& cells);

// The grid with the cells of its holes free.
OccupancyGrid WithHolesFree(OccupancyGrid grid, double max_width_m);

}  // namespace nightmap
