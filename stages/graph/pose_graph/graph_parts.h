// SPDX-License-Identifier: Apache-2.0
// Connectivity of the graph, given the accepted loops.
#pragma once

#include <set>
#include <vector>

#include "stages/graph/pose_graph/optimize_graph.h"
#include "stages/graph/pose_graph/pose_graph.h"

namespace nightmap {

// The part with most frames comes first. A frame belongs to the keyframe at or before it; frame 0
// is a keyframe.
std::vector<GraphPart> FindParts(const std::vector<GraphEdge>& edges,
                                 const std::set<int>& keyframes,
                                 int num_frames);

// Whether an accepted loop joins the first tenth of the keyframes to the last.
bool ReturnsToStart(const std::vector<GraphEdge>& edges, const std::set<int>& keyframes);

}  // namespace nightmap
