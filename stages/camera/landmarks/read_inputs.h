// SPDX-License-Identifier: Apache-2.0
// Inputs of the landmarks stage.
#pragma once

#include "pipeline/program/stage_main.h"
#include "stages/camera/landmarks/landmarks.h"

namespace nightmap {

// The input without features under the masks, where there are masks. `tree` must outlive it. Throws
// UsageError when masks come without their list of frames or the other way round.
LandmarksInput ReadLandmarksInput(const VocabularyTree& tree, const StageContext& context);

}  // namespace nightmap
