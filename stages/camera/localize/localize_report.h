// SPDX-License-Identifier: Apache-2.0
// Summary of localize's results.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "pipeline/io/queries_io.h"

namespace nightmap {

// Counts by verdict and by reason, and medians over the located queries.
nlohmann::json SummarizeQueries(const std::vector<QueryResult>& queries);

}  // namespace nightmap
