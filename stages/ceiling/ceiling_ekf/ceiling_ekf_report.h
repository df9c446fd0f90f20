// SPDX-License-Identifier: Apache-2.0
// Report of ceiling_ekf.
#pragma once

#include <nlohmann/json.hpp>

#include "stages/ceiling/ceiling_ekf/ceiling_ekf.h"

namespace nightmap {

// For report.json.
nlohmann::json Summarize(const CeilingEkfResult& result);

}  // namespace nightmap
