// SPDX-License-Identifier: Apache-2.0
// Outputs of the moving stage.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "stages/labels/moving/moving.h"

namespace nightmap {

// In order of frames, without those that failed.
std::vector<PackedMask> MasksOf(const MovingResult& result);

// The frames, each with the channel of its mask in the file of that name, if it has one.
std::vector<FrameRecord> FramesWithMasks(const std::vector<FrameRecord>& frames,
                                         const MovingResult& result,
                                         const std::string& file);

// For the report: counts, and the share of the pixels of each frame that move.
nlohmann::json Summarize(const MovingResult& result);

}  // namespace nightmap
