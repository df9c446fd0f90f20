// SPDX-License-Identifier: Apache-2.0
// The files of the grid stage.
#pragma once

#include "pipeline/program/stage_main.h"
#include "stages/dense/grid/grid.h"

namespace nightmap {

// Writes map.pgm and map.yaml (ports `pgm` and `yaml`) and map.png of the main floor; the same
// files as floor_N for every other floor N (FloorFiles); distances.h5; and floors.json, which lists
// the floors. Removes the files of floors that an earlier run found.
void WriteGrids(const GridResult& result, StageContext& context);

// Figures of the main floor for report.json; `floors` holds those of each floor.
nlohmann::json DescribeGrids(const GridResult& result);

}  // namespace nightmap
