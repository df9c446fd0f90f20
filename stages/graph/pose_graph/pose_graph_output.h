// SPDX-License-Identifier: Apache-2.0
// The pose_graph stage's text outputs.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "stages/graph/pose_graph/pose_graph.h"

namespace nightmap {

// Header frame_a,frame_b,status,reason,score,num_putative,num_inliers,drift,error; the last two are
// Mahalanobis distances.
std::string LoopsToCsv(const std::vector<LoopRecord>& loops);

nlohmann::json Summarize(const PoseGraphInput& input, const PoseGraphResult& result);

}  // namespace nightmap
