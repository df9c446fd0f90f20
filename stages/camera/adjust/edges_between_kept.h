// SPDX-License-Identifier: Apache-2.0
// The edges of the pose graph after redundant keyframes were dropped.
#pragma once

#include <set>
#include <vector>

#include "pipeline/graph/closed_graph_io.h"
#include "pipeline/io/matches_io.h"

namespace nightmap {

// Edges of odometry bypass a dropped keyframe; loops and edges of other sensors move to the
// keyframe that is nearest now. Without rejected loops, replaced bridges and priors. `kept` has
// frame 0 and both ends of every bridge; graph.is_loop_accepted[i] belongs to loops[i].
std::vector<PoseEdge> EdgesBetweenKept(const ClosedGraph& graph,
                                       const std::vector<FramePair>& loops,
                                       const std::set<int>& kept);

}  // namespace nightmap
