// SPDX-License-Identifier: Apache-2.0
// import_grid: takes a ROS map made by another system in place of the grid stage's.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/grid_io.h"

namespace nightmap {

struct ImportGridOptions {
  REGISTER_OPTIONS();
};

// The map's figures for report.json. Throws InputError when no cell is free.
nlohmann::json RunImportGrid(const OccupancyGrid& grid);

// The frame of the map of `file` must be that of the site's trajectory. Throws DataError naming the
// file when the grid holds no camera pose of the site in a cell that it
// knows, so that it must be elsewhere; warns when it has less than half of them in free cells.
void CheckPlace(const OccupancyGrid& grid,
                const std::vector<StampedPose>& trajectory,
                const std::string& file);

}  // namespace nightmap
