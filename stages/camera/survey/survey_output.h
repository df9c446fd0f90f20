// SPDX-License-Identifier: Apache-2.0
// Files of a survey; docs/formats.md describes them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "pipeline/program/stage_context.h"
#include "stages/camera/survey/survey.h"

namespace nightmap {

// CSV, one row per surveyed frame. Fields of what a frame lacks are empty.
std::string SurveyToCsv(const SurveyResult& result, const std::vector<FrameRecord>& frames);

// Writes mask_N.png beside the output `frames`, N as the camera counts in cameras.json: white where
// something stays in place in all pictures, at their size, grown a little because edges are blurred
// and parts shake. Removes those of cameras that need none.
void WriteMasks(const std::vector<FixedParts>& fixed_parts,
                const std::vector<RgbdCamera>& cameras,
                StageContext& context);

// Counts, how depth and color lie on each other per window, and what stays in place per camera.
nlohmann::json Summarize(const SurveyResult& result,
                         const std::vector<FrameRecord>& frames,
                         const std::vector<RgbdCamera>& cameras);

}  // namespace nightmap
