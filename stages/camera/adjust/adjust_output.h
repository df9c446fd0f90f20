// SPDX-License-Identifier: Apache-2.0
// The adjust stage's cameras and report.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "stages/camera/adjust/adjust.h"

namespace nightmap {

// The cameras with the focal lengths that the adjustment found.
std::vector<RgbdCamera> CalibratedCameras(const AdjustInput& input, const AdjustResult& result);

nlohmann::json Summarize(const AdjustOptions& options,
                         const AdjustInput& input,
                         const AdjustResult& result);

}  // namespace nightmap
