// SPDX-License-Identifier: Apache-2.0
// What a stage tells of its bundle adjustments.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "pipeline/geometry/bundle_adjustment.h"

namespace nightmap {

// For report.json, in order, each with: initial_cost, final_cost (half the robust sum of squares
// over the variances), num_iterations, num_accepted_steps, and how it ended.
nlohmann::json BundleReport(const std::vector<BundleSummary>& adjustments);

// Logs a warning when one stalled.
void WarnOfStalls(const std::vector<BundleSummary>& adjustments);

}  // namespace nightmap
