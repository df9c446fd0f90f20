// SPDX-License-Identifier: Apache-2.0
// Outputs of the landmarks stage for COLMAP.
#pragma once

#include <filesystem>

#include "pipeline/program/stage_main.h"
#include "stages/camera/landmarks/landmarks.h"

namespace nightmap {

// Throws UsageError when only a part of a model is asked for: COLMAP reads all three files or none.
void CheckColmapOutputs(const StageContext& context);

// Writes those files of the COLMAP model of landmarks.h5, and its database, that are outputs of the
// run. Adds the model's figures to the report. Does nothing when none is an output.
void WriteColmap(const LandmarksInput& input,
                 const std::filesystem::path& landmarks,
                 StageContext& context);

}  // namespace nightmap
