// SPDX-License-Identifier: Apache-2.0
// Outputs of the ghosts stage.
#pragma once

#include <vector>

#include "pipeline/program/stage_main.h"
#include "stages/labels/ghosts/ghosts.h"

namespace nightmap {

// Writes the masks in order of time, and the frames, of which those with a mask name it.
void WriteGhosts(const GhostsResult& result,
                 std::vector<FrameRecord> frames,
                 StageContext& context);

}  // namespace nightmap
