// SPDX-License-Identifier: Apache-2.0
// Counts of a shard's tracks for the report.
#pragma once

#include <nlohmann/json.hpp>

#include "stages/ceiling/ceiling_tracks/ceiling_tracks.h"

namespace nightmap {

nlohmann::json CeilingTracksReport(const CeilingTracksResult& result);

}  // namespace nightmap
