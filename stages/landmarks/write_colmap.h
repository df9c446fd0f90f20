// SPDX-License-Identifier: Apache-2.0
// Those outputs of the landmarks stage that are for COLMAP.
#pragma once

#include "pipeline/program/stage_main.h"
#include "stages/landmarks/landmarks.h"

namespace nightmap {

// Throws UsageError when a part of a model is asked for, of which COLMAP reads all three files or
// none.
void CheckColmapOutputs(const StageContext& context);

// Writes the files of the COLMAP model, and its database, that are outputs of the run, and puts the
// model's figures into the report. Makes nothing when none is an output.
void WriteColmap(const LandmarksInput& input, const LandmarkMap& map, StageContext& context);

}  // namespace nightmap
