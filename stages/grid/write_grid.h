// SPDX-License-Identifier: Apache-2.0
// The files of the grid stage.
#pragma once

#include "pipeline/program/stage_main.h"
#include "stages/grid/grid.h"

namespace nightmap {

// Writes of the main floor map.pgm and map.yaml (ports `pgm` and `yaml`) and map.png; of every
// other floor the same as floor_N, N its number (FloorFiles); distances.h5; and floors.json, which
// lists what there is. Removes the files of floors that an earlier run found.
void WriteGrids(const GridResult& result, StageContext& context);

// report.json: the figures of the main floor, and under `floors` those of each.
nlohmann::json DescribeGrids(const GridResult& result);

}  // namespace nightmap
