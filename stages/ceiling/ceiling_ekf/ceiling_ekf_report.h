// SPDX-License-Identifier: Apache-2.0
// What ceiling_ekf says of its result.
#pragma once

#include <nlohmann/json.hpp>

#include "stages/ceiling/ceiling_ekf/ceiling_ekf.h"

namespace nightmap {

// For report.json.
nlohmann::json Summarize(const CeilingEkfResult& result);

}  // namespace nightmap
