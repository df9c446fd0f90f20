// SPDX-License-Identifier: Apache-2.0
// Classifies the cells of one floor from the columns above its ground. RunGrid states the rules.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "stages/dense/grid/columns.h"
#include "stages/dense/grid/grid.h"

namespace nightmap {

// Returns the whole area of the columns, not cropped, with all counts except those of cells.
// `ground_m` comes from FindGround.
FloorGrid ClassifyFloor(const GridOptions& options,
                        const Columns& columns,
                        const std::vector<double>& ground_m,
                        double floor_m,
                        const std::vector<Eigen::Vector3d>& cameras_in_map,
                        int num_threads);

}  // namespace nightmap
