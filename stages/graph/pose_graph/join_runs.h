// SPDX-License-Identifier: Apache-2.0
// Finds how recordings, or runs between lost tracking, lie relative to each other. Optimization
// needs a good initial guess: from one that is metres off, it would reject the correct loops.
#pragma once

#include <vector>

#include "pipeline/io/odometry_io.h"

namespace nightmap {

// A tree over all keyframes: the odometry, but with each bridge replaced by the loop that most
// others agree with, if at least three agree. `odometry` joins keyframes in order, across bridges
// too; `max_drift` is the Mahalanobis distance within which two loops agree. Deterministic.
std::vector<PoseEdge> JoinRuns(const std::vector<PoseEdge>& odometry,
                               const std::vector<PoseEdge>& loops,
                               double max_drift);

}  // namespace nightmap
