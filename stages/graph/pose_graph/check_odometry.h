// SPDX-License-Identifier: Apache-2.0
// Refuses inconsistent artifacts before the graph is built from them.
#pragma once

#include "stages/graph/pose_graph/pose_graph.h"

namespace nightmap {

// Odometry must cover the frames in order, the first frame must be a keyframe, edges must join
// keyframes and each shard to the one before it, loops must lie between frames. Throws DataError
// naming frame and remedy.
void CheckInput(const PoseGraphInput& input);

}  // namespace nightmap
