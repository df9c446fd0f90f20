// SPDX-License-Identifier: Apache-2.0
// Report and log of the landmark map.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "stages/camera/landmarks/landmarks.h"

namespace nightmap {

nlohmann::json SummarizeLandmarks(const LandmarksFigures& figures);

// States what max_landmarks dropped, and the remedy; empty when it dropped nothing.
std::string DroppedLandmarks(const LandmarksFigures& figures);

}  // namespace nightmap
