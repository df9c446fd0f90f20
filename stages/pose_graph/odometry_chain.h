// SPDX-License-Identifier: Apache-2.0
// Where the odometry alone puts every frame.
#pragma once

#include <cstddef>
#include <map>
#include <set>
#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "stages/pose_graph/pose_graph.h"

namespace nightmap {

struct OdometryChain {
  std::vector<Rigid3> graph_from_camera;  // of every frame; the graph's frame is the first shard's
  std::set<int> keyframes;
  std::vector<PoseEdge> edges;  // of all shards, no surer than the options allow
  std::set<int> after_bridge;   // keyframes that only a guess joins to the one before

  const Rigid3& At(int frame_idx) const {
    return graph_from_camera[static_cast<std::size_t>(frame_idx)];
  }
  // Odometry does not know the way from a keyframe to the next one.
  bool IsBridged(int before, int after) const {
    return before < after && after_bridge.contains(after);
  }
};

// Calibration and synchronization errors do not show in an edge's own Hessian.
PoseEdge WithSigmaFloor(const PoseGraphOptions& options, PoseEdge edge);

// Joins the shards by each one's first edge. The input is one that CheckInput passed.
OdometryChain ChainOdometry(const PoseGraphOptions& options, const PoseGraphInput& input);

}  // namespace nightmap
