// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment of all keyframes after loop closure.
#pragma once

#include <map>

#include "stages/pose_graph/pose_graph.h"

namespace nightmap {

struct GlobalBundleSummary {
  double rms_px = 0;
  int num_observations = 0;
};

// Merges the shards' tracks where they share a feature and where an accepted loop joins two, keeps
// the longest of each keyframe, and adjusts keyframes and points. `is_accepted[i]` tells of
// input.loops[i]. The first keyframe is held fixed: it is the graph's gauge.
GlobalBundleSummary AdjustKeyframes(const PoseGraphOptions& options,
                                    const PoseGraphInput& input,
                                    const std::vector<bool>& is_accepted,
                                    std::map<int, Rigid3>* graph_from_keyframe);

}  // namespace nightmap
