// SPDX-License-Identifier: Apache-2.0
// A ground truth by another clock than the frames it belongs to.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "pipeline/recording/read_sequence.h"

namespace nightmap {

// Reports, and warns of, each ground truth that gives no frame of its sequence a pose (TruthAt):
// file (relative to the data folder) and apart_s, the least time in seconds from one of its poses
// to a frame. Sets no key when all truths fit. Deterministic.
void ReportTruthsApart(const std::vector<RawSequence>& sequences, nlohmann::json& report);

}  // namespace nightmap
