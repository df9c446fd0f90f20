// SPDX-License-Identifier: Apache-2.0
// Report of ceiling_adjust.
#pragma once

#include <nlohmann/json.hpp>

#include "stages/ceiling/ceiling_adjust/ceiling_adjust.h"

namespace nightmap {

// For report.json.
nlohmann::json Summarize(const CeilingAdjustResult& result);

}  // namespace nightmap
