// SPDX-License-Identifier: Apache-2.0
// What report.json and the log say of the map of landmarks.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "stages/landmarks/landmarks.h"

namespace nightmap {

nlohmann::json SummarizeLandmarks(const LandmarksResult& result);

// What max_landmarks dropped, and the remedy; empty when it dropped nothing.
std::string DroppedLandmarks(const LandmarksResult& result);

}  // namespace nightmap
