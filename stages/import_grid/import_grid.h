// SPDX-License-Identifier: Apache-2.0
// import_grid: takes a ROS map made by another system in place of the grid stage's.
#pragma once

#include "pipeline/program/stage_main.h"

namespace nightmap {

struct ImportGridOptions {
  void Register(OptionList&) {}
};

// Reads the map of the input `map` (a YAML file; its PGM is found next to it and becomes an input
// too) and writes it as the grid stage does: outputs floors, pgm, yaml and png, one floor at z = 0.
// Its frame must be that of the site's map. Throws DataError as ReadGrid does, and when no cell is
// free.
void ImportGrid(const ImportGridOptions& options, StageContext& context);

}  // namespace nightmap
