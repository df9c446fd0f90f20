// SPDX-License-Identifier: Apache-2.0
// import_grid: takes a ROS map made by another system in place of the grid stage's.
#pragma once

#include <string>
#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/grid_io.h"
#include "pipeline/program/stage_main.h"

namespace nightmap {

struct ImportGridOptions {
  void Register(OptionList&) {}
};

// Reads the map of the input `map` (a YAML file; its PGM is found next to it and becomes an input
// too) and writes it as the grid stage does: outputs floors, pgm, yaml and png, one floor at z = 0.
// Its frame must be that of the site's map. Throws DataError as ReadGrid and CheckPlace do, and
// when no cell is free.
void ImportGrid(const ImportGridOptions& options, StageContext& context);

// Throws DataError naming `file` when the grid holds no camera pose of the site in a cell that it
// knows, so that it must be elsewhere; warns when it has less than half of them in free cells.
void CheckPlace(const OccupancyGrid& grid,
                const std::vector<StampedPose>& trajectory,
                const std::string& file);

}  // namespace nightmap
