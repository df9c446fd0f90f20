// SPDX-License-Identifier: Apache-2.0
// Finds the frames of the edges of other sensors.
#pragma once

#include <vector>

#include "pipeline/graph/sensor_edges.h"
#include "stages/graph/pose_graph/pose_graph.h"

namespace nightmap {

// One for each sensor, in the order in which the files name them. Throws InputError naming file and
// time when a node is no frame, or sensor when its odometry overlaps or joins two recordings.
std::vector<SensorGraph> MakeSensorGraphs(const PoseGraphInput& input);

}  // namespace nightmap
