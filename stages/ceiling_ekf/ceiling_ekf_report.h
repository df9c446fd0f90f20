// SPDX-License-Identifier: Apache-2.0
// What ceiling_ekf reads of the lists, and says of its result.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "stages/ceiling_ekf/ceiling_ekf.h"

namespace nightmap {

// The camera of all frames. Throws InputError of the port `frames` when they are of several cameras
// or recordings: the filter follows one robot without a break.
RgbdCamera OneCamera(const std::vector<FrameRecord>& frames,
                     const std::vector<RgbdCamera>& cameras);

// For report.json.
nlohmann::json Summarize(const CeilingEkfResult& result);

}  // namespace nightmap
