// SPDX-License-Identifier: Apache-2.0
// Poses of all frames by odometry alone, and edges moved along them to keyframes.
#pragma once

#include <cstddef>
#include <optional>
#include <set>
#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/matches_io.h"
#include "pipeline/io/odometry_io.h"

namespace nightmap {

// Added in quadrature to the sigmas of every edge, because its Hessian does not show calibration
// and synchronization errors.
struct EdgeSigmaFloor {
  double m = 0.003;
  double rad = 0.002;
};

struct OdometryChain {
  std::vector<Rigid3> graph_from_camera;  // by frame; the graph's frame is the first shard's
  std::set<int> keyframes;                // has frame 0
  std::vector<PoseEdge> edges;  // of all shards, with the floor; each begins where one before ends
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

PoseEdge WithSigmaFloor(const EdgeSigmaFloor& floor, PoseEdge edge);

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

// The edge of a verified loop between the nearest keyframes, with the floor; none: not verified, or
// both are one keyframe.
std::optional<PoseEdge> LoopAtKeyframes(const EdgeSigmaFloor& floor,
                                        const OdometryChain& chain,
                                        const std::set<int>& keyframes,
                                        const FramePair& loop);

}  // namespace nightmap
