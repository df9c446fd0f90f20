// SPDX-License-Identifier: Apache-2.0
#include "stages/pose_graph/odometry_chain.h"

#include <iterator>

namespace nightmap {
namespace {

Rigid3 GraphFromShard(const OdometryChain& chain, const OdometryShard& shard) {
  if (shard.edges.empty() || shard.edges[0].frame_a >= shard.frames[0].frame_idx) return {};
  const PoseEdge& join = shard.edges[0];
  const auto b = static_cast<std::size_t>(join.frame_b - shard.frames[0].frame_idx);
  return chain.At(join.frame_a) * join.b_from_a.Inverse() *
         shard.frames.at(b).shard_from_camera.Inverse();
}

int NearestKeyframe(const OdometryChain& chain, const std::set<int>& keyframes, int frame_idx) {
  const int before = *std::prev(keyframes.upper_bound(frame_idx));
  const auto after = keyframes.lower_bound(frame_idx);
  if (after == keyframes.end() || chain.IsBridged(before, *after)) return before;
  return *after - frame_idx < frame_idx - before ? *after : before;
}

}  // namespace

PoseEdge WithSigmaFloor(const PoseGraphOptions& options, PoseEdge edge) {
  const double rad2 = options.edge_sigma_floor_rad * options.edge_sigma_floor_rad;
  const double m2 = options.edge_sigma_floor_m * options.edge_sigma_floor_m;
  edge.covariance.diagonal().head<3>().array() += rad2;
  edge.covariance.diagonal().tail<3>().array() += m2;
  return edge;
}

PoseEdge Chained(const PoseEdge& first, const PoseEdge& second) {
  const Matrix6d adjoint = Adjoint(second.b_from_a);
  return {first.frame_a,
          second.frame_b,
          second.b_from_a * first.b_from_a,
          second.covariance + adjoint * first.covariance * adjoint.transpose(),
          false};
}

PoseEdge MoveToKeyframe(const OdometryChain& chain,
                        const std::set<int>& keyframes,
                        const PoseEdge& edge) {
  const int b = NearestKeyframe(chain, keyframes, edge.frame_b);
  const Rigid3 b_from_a = chain.At(b).Inverse() * chain.At(edge.frame_b) * edge.b_from_a;
  return {edge.frame_a, b, b_from_a, edge.covariance, false};
}

std::optional<PoseEdge> JoinKeyframes(const OdometryChain& chain,
                                      const std::set<int>& keyframes,
                                      const PoseEdge& edge) {
  const int a = NearestKeyframe(chain, keyframes, edge.frame_a);
  const int b = NearestKeyframe(chain, keyframes, edge.frame_b);
  if (a >= b) return std::nullopt;
  const Rigid3 b_from_a = chain.At(b).Inverse() * chain.At(edge.frame_b) * edge.b_from_a *
                          chain.At(edge.frame_a).Inverse() * chain.At(a);
  return PoseEdge{a, b, b_from_a, edge.covariance, false};
}

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
      chain.edges.push_back(WithSigmaFloor(options, edge));
      if (edge.is_bridge) chain.after_bridge.insert(edge.frame_b);
    }
  }
  return chain;
}

}  // namespace nightmap
