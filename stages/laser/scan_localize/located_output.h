// SPDX-License-Identifier: Apache-2.0
// Outputs of scan_localize beside queries.csv.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pipeline/program/stage_main.h"
#include "stages/laser/scan_localize/scan_localize.h"

namespace nightmap {

// candidates.csv: a row per candidate of each query, the best first:
//   query_idx,rank,x_m,y_m,heading_rad,fit,walls_fit,score,search_score,through_share,
//   num_confirmed,num_contradicted,sigma_x_m,sigma_y_m,sigma_heading_rad,correlation_xy
std::string CandidatesToCsv(const std::vector<LocatedScan>& located);

// object_poses.csv: the second list of the method `published`, a row per pose at which an object is
// where the map has it:
//   query_idx,object_idx,x_m,y_m,heading_rad,num_in_sight,overlap
// object_idx counts the objects of objects.yaml from 0.
std::string ObjectPosesToCsv(const std::vector<LocatedScan>& located);

// Counts by verdict and reason, and medians of the located, for report.json.
nlohmann::json SummarizeScans(const std::vector<LocatedScan>& located);

// Writes every output, and fills the report.
void WriteLocated(const std::vector<LocatedScan>& located, StageContext& context);

}  // namespace nightmap
