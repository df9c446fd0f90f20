// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/chain_odometry.h"

namespace nightmap {
namespace {

Rigid3 GraphFromShard(const OdometryChain& chain, const OdometryShard& shard) {
  if (shard.edges.empty() || shard.edges[0].frame_a >= shard.frames[0].frame_idx) return {};
  const PoseEdge& join = shard.edges[0];
  const auto b = static_cast<std::size_t>(join.frame_b - shard.frames[0].frame_idx);
  return chain.At(join.frame_a) * join.b_from_a.Inverse() *
         shard.frames.at(b).shard_from_camera.Inverse();
}

}  // namespace

OdometryChain ChainOdometry(const PoseGraphOptions& options, const PoseGraphInput& input) {
  OdometryChain chain;
  for (const OdometryShard& shard : input.odometry) {
    if (shard.frames.empty()) continue;
    const Rigid3 graph_from_shard = GraphFromShard(chain, shard);
    for (const OdometryFrame& frame : shard.frames) {
      chain.graph_from_camera.push_back(graph_from_shard * frame.shard_from_camera);
      if (frame.is_keyframe) chain.keyframes.insert(frame.frame_idx);
      if (frame.state == TrackingState::kBridged) chain.guessed.insert(frame.frame_idx);
    }
    for (const PoseEdge& edge : shard.edges) {
      chain.edges.push_back(WithSigmaFloor(options.edge_sigma_floor, edge));
      if (edge.is_bridge) chain.after_bridge.insert(edge.frame_b);
    }
  }
  return chain;
}

}  // namespace nightmap
