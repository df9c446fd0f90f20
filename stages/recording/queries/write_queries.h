// SPDX-License-Identifier: Apache-2.0
// The files of the queries stage.
#pragma once

#include <vector>

#include "pipeline/program/stage_main.h"
#include "stages/recording/queries/queries.h"

namespace nightmap {

// Writes queries.csv, query_cameras.json and, if there is any truth, query_ground_truth.tum beside
// the output `list`. A file whose bytes did not change is left untouched. Then writes the list of
// the pictures and fills the report. The camera_idx of `lists` are indices into `cameras`, those of
// queries.csv into query_cameras.json.
void WriteQueries(const std::vector<RgbdCamera>& cameras, QueryLists lists, StageContext& context);

}  // namespace nightmap
