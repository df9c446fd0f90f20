// SPDX-License-Identifier: Apache-2.0
#include "pipeline/graph/sensor_edges.h"

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

}  // namespace

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

std::optional<PoseEdge> AtKeyframes(const EdgeSigmaFloor& floor,
                                    const OdometryChain& chain,
                                    const std::set<int>& keyframes,
                                    const PoseEdge& edge) {
  const bool is_prior = edge.frame_a == kMapNode;
  if (!IsPlaced(chain, keyframes, edge.frame_b)) return std::nullopt;
  if (!is_prior && !IsPlaced(chain, keyframes, edge.frame_a)) return std::nullopt;
  const auto moved =
      is_prior ? MoveToKeyframe(chain, keyframes, edge) : JoinKeyframes(chain, keyframes, edge);
  if (!moved) return std::nullopt;
  return WithSigmaFloor(floor, *moved);
}

namespace {

// Chained from keyframe to keyframe. Leaves out what fills a bridge.
std::vector<PoseEdge> OdometryOfSensors(const EdgeSigmaFloor& floor,
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
      const auto edge = AtKeyframes(floor, chain, keyframes, stretch.edge);
      if (edge) edges.push_back(*edge);
    }
  }
  return edges;
}

}  // namespace

std::vector<PoseEdge> MeasuredBySensors(const EdgeSigmaFloor& floor,
                                        const OdometryChain& chain,
                                        const std::set<int>& keyframes,
                                        const std::vector<SensorGraph>& sensors,
                                        const FilledBridges& filled) {
  std::vector<PoseEdge> edges = OdometryOfSensors(floor, chain, keyframes, sensors, filled);
  for (const SensorGraph& sensor : sensors) {
    for (const PoseEdge& prior : sensor.priors) {
      if (const auto edge = AtKeyframes(floor, chain, keyframes, prior)) edges.push_back(*edge);
    }
  }
  return edges;
}

}  // namespace nightmap
