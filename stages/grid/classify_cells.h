// SPDX-License-Identifier: Apache-2.0
// The cells of one floor, from what the columns hold over its ground. RunGrid has the rules.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "stages/grid/columns.h"
#include "stages/grid/grid.h"

namespace nightmap {

// The whole area of the columns, not cropped, with all counts but those of cells. `ground_m` as of
// FindGround.
FloorGrid ClassifyFloor(const GridOptions& options,
                        const Columns& columns,
                        const std::vector<double>& ground_m,
                        double floor_m,
                        const std::vector<Eigen::Vector3d>& cameras_in_map,
                        int num_threads);

}  // namespace nightmap
