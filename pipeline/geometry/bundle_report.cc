// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/bundle_report.h"

#include <spdlog/spdlog.h>

namespace nightmap {

nlohmann::json BundleReport(const std::vector<BundleSummary>& adjustments) {
  auto report = nlohmann::json::array();
  for (const BundleSummary& adjustment : adjustments) {
    report.push_back({{"initial_cost", adjustment.initial_cost},
                      {"final_cost", adjustment.final_cost},
                      {"num_iterations", adjustment.num_iterations},
                      {"num_accepted_steps", adjustment.num_accepted},
                      {"end", BundleEndText(adjustment.end)}});
  }
  return report;
}

void WarnOfStalls(const std::vector<BundleSummary>& adjustments) {
  for (const BundleSummary& adjustment : adjustments) {
    if (adjustment.end != BundleEnd::kStalled) continue;
    spdlog::warn(
        "bundle adjustment stalled at a cost of {:.6g} (it began at {:.6g}): no further step "
        "lowers "
        "it; look at the trajectory before using the map",
        adjustment.final_cost,
        adjustment.initial_cost);
  }
}

}  // namespace nightmap
