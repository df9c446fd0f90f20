// SPDX-License-Identifier: Apache-2.0
// Edges of other sensors (wheels, scans, surveyed poses) between frames.
#pragma once

#include <string>
#include <vector>

#include "stages/pose_graph/pose_graph.h"

namespace nightmap {

// Source of a prior: the map, a node at the identity that is no frame.
constexpr int kMapNode = -1;

// All edges of one sensor, between frames. Covariances are as measured, without the options' floor.
struct SensorGraph {
  std::string sensor;
  std::vector<PoseEdge> odometry;  // ascending: each begins where the one before ends, or later
  std::vector<PoseEdge> loops;     // from the earlier frame to the later one
  std::vector<PoseEdge> priors;    // from kMapNode to a frame: camera_from_map
};

// One for each sensor, in the order in which the files name them. Throws InputError naming file and
// time when a node is no frame, or sensor when its odometry overlaps or joins two recordings.
std::vector<SensorGraph> MakeSensorGraphs(const PoseGraphInput& input);

}  // namespace nightmap
