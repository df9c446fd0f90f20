// SPDX-License-Identifier: Apache-2.0
// Counts of a shard's features for the report.
#pragma once

#include <nlohmann/json.hpp>

#include "pipeline/io/features_io.h"

namespace nightmap {

nlohmann::json Summarize(const FeaturesShard& shard);

}  // namespace nightmap
