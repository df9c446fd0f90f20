// SPDX-License-Identifier: Apache-2.0
// Files of a survey; docs/formats.md describes them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "stages/survey/survey.h"

namespace nightmap {

// CSV, one row per surveyed frame. Fields of what a frame lacks are empty.
std::string SurveyToCsv(const SurveyResult& result, const std::vector<FrameRecord>& frames);

// Counts, and how depth and color lie on each other per window.
nlohmann::json Summarize(const SurveyResult& result, const std::vector<FrameRecord>& frames);

}  // namespace nightmap
