// SPDX-License-Identifier: Apache-2.0
// What scan_localize writes beside queries.csv.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "stages/scan_localize/scan_localize.h"

namespace nightmap {

// candidates.csv: a row per candidate of each query, the best first:
//   query_idx,rank,x_m,y_m,heading_rad,fit,walls_fit,score,search_score,through_share,
//   num_confirmed,num_contradicted,sigma_x_m,sigma_y_m,sigma_heading_rad,correlation_xy
std::string CandidatesToCsv(const std::vector<LocatedScan>& located);

// Counts by verdict and reason, and medians of the located, for report.json.
nlohmann::json SummarizeScans(const std::vector<LocatedScan>& located);

}  // namespace nightmap
