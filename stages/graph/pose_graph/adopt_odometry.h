// SPDX-License-Identifier: Apache-2.0
// Where no camera recorded, another sensor's odometry is what the graph hangs on.
#pragma once

#include "stages/graph/pose_graph/pose_graph.h"

namespace nightmap {

// Makes the nodes of the first file with odometry the frames of `input`, all of them keyframes, and
// moves its odometry from the edges to one shard. An edge that does not begin where the one before
// ends is preceded by a bridge. Throws InputError of the port `edges` when no file has odometry, or
// when motions overlap.
void AdoptOdometry(PoseGraphInput* input);

}  // namespace nightmap
