// SPDX-License-Identifier: Apache-2.0
// Where recordings, or runs between lost tracking, lie relative to each other. Optimization needs a
// start that is near: from a guess metres off, it would believe none of the right loops.
#pragma once

#include <vector>

#include "pipeline/io/odometry_io.h"

namespace nightmap {

// A tree over all keyframes: the odometry, in which the loop that most others agree with stands in
// for the bridge, wherever at least three agree. `odometry` joins keyframes in order, across
// bridges too; `max_drift` is the Mahalanobis distance within which two loops agree. Deterministic.
std::vector<PoseEdge> JoinRuns(const std::vector<PoseEdge>& odometry,
                               const std::vector<PoseEdge>& loops,
                               double max_drift);

}  // namespace nightmap
