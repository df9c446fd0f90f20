// SPDX-License-Identifier: Apache-2.0
// The files of the queries stage.
#pragma once

#include <vector>

#include "pipeline/program/stage_main.h"
#include "stages/queries/queries.h"

namespace nightmap {

// Writes queries.csv, query_cameras.json and, where there is any, query_ground_truth.tum beside the
// output `list`, each kept as it is when its bytes did not change, then the list of the pictures,
// and fills the report. The camera_idx of `lists` count in `cameras`, those of queries.csv in
// query_cameras.json.
void WriteQueries(const std::vector<RgbdCamera>& cameras, QueryLists lists, StageContext& context);

}  // namespace nightmap
