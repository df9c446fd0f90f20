// SPDX-License-Identifier: Apache-2.0
// How the graph holds together, once it is decided which loops to believe.
#pragma once

#include <set>
#include <vector>

#include "stages/pose_graph/optimize_graph.h"
#include "stages/pose_graph/pose_graph.h"

namespace nightmap {

// Most frames first. A frame belongs to the keyframe at or before it; frame 0 is a keyframe.
std::vector<GraphPart> FindParts(const std::vector<GraphEdge>& edges,
                                 const std::set<int>& keyframes,
                                 int num_frames);

// Whether a believed loop joins the first tenth of the keyframes to the last.
bool ReturnsToStart(const std::vector<GraphEdge>& edges, const std::set<int>& keyframes);

}  // namespace nightmap
