// SPDX-License-Identifier: Apache-2.0
#include "pipeline/graph/odometry_chain.h"

#include <iterator>

namespace nightmap {
namespace {

int NearestKeyframe(const OdometryChain& chain, const std::set<int>& keyframes, int frame_idx) {
  const int before = *std::prev(keyframes.upper_bound(frame_idx));
  const auto after = keyframes.lower_bound(frame_idx);
  if (after == keyframes.end() || chain.IsBridged(before, *after)) return before;
  return *after - frame_idx < frame_idx - before ? *after : before;
}

}  // namespace

PoseEdge WithSigmaFloor(const EdgeSigmaFloor& floor, PoseEdge edge) {
  const double rad2 = floor.rad * floor.rad;
  const double m2 = floor.m * floor.m;
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

std::optional<PoseEdge> LoopAtKeyframes(const EdgeSigmaFloor& floor,
                                        const OdometryChain& chain,
                                        const std::set<int>& keyframes,
                                        const FramePair& loop) {
  if (loop.status != PairStatus::kAccepted) return std::nullopt;
  const auto edge = JoinKeyframes(
      chain, keyframes, {loop.frame_a, loop.frame_b, loop.b_from_a, loop.covariance, false});
  if (!edge) return std::nullopt;
  return WithSigmaFloor(floor, *edge);
}

}  // namespace nightmap
