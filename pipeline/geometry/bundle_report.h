// SPDX-License-Identifier: Apache-2.0
// Reports and warnings on a stage's bundle adjustments.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "pipeline/geometry/bundle_adjustment.h"

namespace nightmap {

// One entry per adjustment for report.json, in order: initial_cost, final_cost (half the robust sum
// of squares over the variances), num_iterations, num_accepted_steps, and how it ended.
nlohmann::json BundleReport(const std::vector<BundleSummary>& adjustments);

// Logs a warning for each adjustment that stalled.
void WarnOfStalls(const std::vector<BundleSummary>& adjustments);

}  // namespace nightmap
