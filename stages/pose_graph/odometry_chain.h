// SPDX-License-Identifier: Apache-2.0
// Poses of all frames by odometry alone.
#pragma once

#include <cstddef>
#include <optional>
#include <set>
#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "stages/pose_graph/pose_graph.h"

namespace nightmap {

struct OdometryChain {
  std::vector<Rigid3> graph_from_camera;  // by frame; the graph's frame is the first shard's
  std::set<int> keyframes;
  std::vector<PoseEdge> edges;  // of all shards, with the options' floor on their sigmas
  std::set<int> guessed;        // frames without a verified pair
  std::set<int> after_bridge;   // keyframes that only a guess joins to the one before

  const Rigid3& At(int frame_idx) const {
    return graph_from_camera[static_cast<std::size_t>(frame_idx)];
  }
  // Whether odometry did not measure the motion from a keyframe to the next one.
  bool IsBridged(int before, int after) const {
    return before < after && after_bridge.contains(after);
  }
};

// Raises an edge's sigmas to the floor, because its Hessian does not show calibration and
// synchronization errors.
PoseEdge WithSigmaFloor(const PoseGraphOptions& options, PoseEdge edge);

// The motion of both edges, one after the other.
PoseEdge Chained(const PoseEdge& first, const PoseEdge& second);

// The edge between the keyframes that are nearest to the edge's frames, by the odometry between
// them; none: they are one, or the edge leads back. Does not cross a bridge, because odometry did
// not measure that motion. `keyframes` has frame 0.
std::optional<PoseEdge> JoinKeyframes(const OdometryChain& chain,
                                      const std::set<int>& keyframes,
                                      const PoseEdge& edge);

// The edge to the keyframe that is nearest to its second frame; its first end stays.
PoseEdge MoveToKeyframe(const OdometryChain& chain,
                        const std::set<int>& keyframes,
                        const PoseEdge& edge);

// Joins each shard to the one before it by its first edge. CheckInput must have passed the input.
OdometryChain ChainOdometry(const PoseGraphOptions& options, const PoseGraphInput& input);

}  // namespace nightmap
