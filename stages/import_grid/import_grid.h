// SPDX-License-Identifier: Apache-2.0
// import_grid: a ROS map that another system made, in the place of the grid stage's.
#pragma once

#include "pipeline/program/stage_main.h"

namespace nightmap {

struct ImportGridOptions {
  void Register(OptionList&) {}
};

// Writes the map of the input `map` (YAML; its PGM is found beside it and becomes an input too) as
// the grid stage writes its own: outputs floors, pgm, yaml and png, one floor at z = 0. Its frame
// must be that of the site's map. Throws DataError as ReadGrid does, and when no cell is free.
void ImportGrid(const ImportGridOptions& options, StageContext& context);

}  // namespace nightmap
