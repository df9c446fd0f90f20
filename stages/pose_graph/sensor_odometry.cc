// SPDX-License-Identifier: Apache-2.0
#include "stages/pose_graph/sensor_odometry.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace nightmap {
namespace {

// Whether the odometry tells where the frame is relative to the keyframes around it.
bool IsPlaced(const OdometryChain& chain, const std::set<int>& keyframes, int frame_idx) {
  return !chain.guessed.contains(frame_idx) || keyframes.contains(frame_idx);
}

// The node nearest to each keyframe.
std::set<int> NodesAtKeyframes(const OdometryChain& chain,
                               const std::set<int>& keyframes,
                               const std::vector<PoseEdge>& steps) {
  std::set<int> nodes, nearest;
  for (const PoseEdge& step : steps) {
    for (const int node : {step.frame_a, step.frame_b}) {
      if (IsPlaced(chain, keyframes, node)) nodes.insert(node);
    }
  }
  if (nodes.empty()) return nearest;
  for (const int keyframe : keyframes) {
    const auto after = nodes.lower_bound(keyframe);
    const auto before = after == nodes.begin() ? after : std::prev(after);
    const bool is_after = after != nodes.end() && *after - keyframe < keyframe - *before;
    nearest.insert(is_after || before == after ? *after : *before);
  }
  return nearest;
}

// Consecutive steps of a sensor as one edge.
struct Stretch {
  PoseEdge edge;
  std::vector<PoseEdge> steps;
};

// Cuts the steps at the nodes nearest to keyframes.
std::vector<Stretch> CutAtKeyframes(const OdometryChain& chain,
                                    const std::set<int>& keyframes,
                                    const std::vector<PoseEdge>& steps) {
  const std::set<int> cuts = NodesAtKeyframes(chain, keyframes, steps);
  std::vector<Stretch> stretches;
  std::optional<Stretch> open;
  for (const PoseEdge& step : steps) {
    if (open && open->edge.frame_b == step.frame_a) {
      open->edge = Chained(open->edge, step);
      open->steps.push_back(step);
    } else {
      open.reset();
      if (IsPlaced(chain, keyframes, step.frame_a)) open = Stretch{step, {step}};
    }
    if (!open || !cuts.contains(step.frame_b)) continue;
    stretches.push_back(*std::exchange(open, std::nullopt));
  }
  return stretches;
}

class BridgeFiller {
 public:
  BridgeFiller(const PoseGraphOptions& options, OdometryChain* chain)
      : options_(options), chain_(*chain) {}

  // The keyframe after the bridge that the stretch fills; none: it crosses none, or several.
  std::optional<int> Fill(const Stretch& stretch) {
    const auto start = chain_.after_bridge.upper_bound(stretch.edge.frame_a);
    if (start == chain_.after_bridge.end() || *start > stretch.edge.frame_b) return std::nullopt;
    const auto next = std::next(start);
    if (next != chain_.after_bridge.end() && *next <= stretch.edge.frame_b) return std::nullopt;
    const int first = *start;  // of the frames that move
    PlaceGuessed(stretch, first);
    Measure(stretch.edge, first);
    Interpolate(stretch.edge.frame_a + 1, first);
    chain_.after_bridge.erase(start);
    return first;
  }

 private:
  void PlaceGuessed(const Stretch& stretch, int end) {
    Rigid3 pose = chain_.At(stretch.edge.frame_a);
    for (const PoseEdge& step : stretch.steps) {
      pose = pose * step.b_from_a.Inverse();
      if (step.frame_b >= end || chain_.guessed.erase(step.frame_b) == 0) continue;
      chain_.graph_from_camera[static_cast<std::size_t>(step.frame_b)] = pose;
    }
  }

  // Frames in between that are no nodes.
  void Interpolate(int begin, int end) {
    for (int idx = begin; idx < end; ++idx) {
      if (!chain_.guessed.contains(idx) || chain_.keyframes.contains(idx)) continue;
      int next = idx + 1;
      while (next < end && chain_.guessed.contains(next)) ++next;
      const double fraction = 1.0 / (next - idx + 1);
      const Rigid3& a = chain_.At(idx - 1);
      const Rigid3& b = chain_.At(next);
      chain_.graph_from_camera[static_cast<std::size_t>(idx)] = {
          a.rotation.slerp(fraction, b.rotation),
          (1 - fraction) * a.translation + fraction * b.translation};
    }
  }

  void Measure(const PoseEdge& measured, int first) {
    const auto bridge = std::ranges::find_if(chain_.edges, [&](const PoseEdge& edge) {
      return edge.is_bridge && edge.frame_b == first;
    });
    const int a = bridge->frame_a;
    const Rigid3 b_from_a = chain_.At(first).Inverse() * chain_.At(measured.frame_b) *
                            measured.b_from_a * chain_.At(measured.frame_a).Inverse() *
                            chain_.At(a);
    *bridge = WithSigmaFloor(options_, {a, first, b_from_a, measured.covariance, false});
    const Rigid3 motion = chain_.At(a) * b_from_a.Inverse() * chain_.At(first).Inverse();
    for (auto i = static_cast<std::size_t>(first); i < chain_.graph_from_camera.size(); ++i) {
      chain_.graph_from_camera[i] = motion * chain_.graph_from_camera[i];
    }
  }

  const PoseGraphOptions& options_;
  OdometryChain& chain_;
};

}  // namespace

FilledBridges FillBridges(const PoseGraphOptions& options,
                          const std::vector<SensorGraph>& sensors,
                          OdometryChain* chain) {
  FilledBridges filled;
  BridgeFiller filler(options, chain);
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    for (const Stretch& stretch : CutAtKeyframes(*chain, chain->keyframes, sensors[i].odometry)) {
      if (const auto start = filler.Fill(stretch)) filled.emplace(*start, i);
    }
  }
  return filled;
}

std::optional<PoseEdge> AtKeyframes(const PoseGraphOptions& options,
                                    const OdometryChain& chain,
                                    const std::set<int>& keyframes,
                                    const PoseEdge& edge) {
  const bool is_prior = edge.frame_a == kMapNode;
  if (!IsPlaced(chain, keyframes, edge.frame_b)) return std::nullopt;
  if (!is_prior && !IsPlaced(chain, keyframes, edge.frame_a)) return std::nullopt;
  const auto moved =
      is_prior ? MoveToKeyframe(chain, keyframes, edge) : JoinKeyframes(chain, keyframes, edge);
  if (!moved) return std::nullopt;
  return WithSigmaFloor(options, *moved);
}

std::vector<PoseEdge> OdometryOfSensors(const PoseGraphOptions& options,
                                        const OdometryChain& chain,
                                        const std::set<int>& keyframes,
                                        const std::vector<SensorGraph>& sensors,
                                        const FilledBridges& filled) {
  std::vector<PoseEdge> edges;
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    for (const Stretch& stretch : CutAtKeyframes(chain, keyframes, sensors[i].odometry)) {
      const auto bridge = filled.upper_bound(stretch.edge.frame_a);
      const bool fills = bridge != filled.end() && bridge->first <= stretch.edge.frame_b;
      if (fills && bridge->second == i) continue;
      const auto edge = AtKeyframes(options, chain, keyframes, stretch.edge);
      if (edge) edges.push_back(*edge);
    }
  }
  return edges;
}

}  // namespace nightmap
