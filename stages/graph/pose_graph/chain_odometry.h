// SPDX-License-Identifier: Apache-2.0
// Chains the odometry of all shards.
#pragma once

#include "pipeline/graph/odometry_chain.h"
#include "stages/graph/pose_graph/pose_graph.h"

namespace nightmap {

// Joins each shard to the one before it by its first edge. CheckInput must have passed the input.
OdometryChain ChainOdometry(const PoseGraphOptions& options, const PoseGraphInput& input);

}  // namespace nightmap
