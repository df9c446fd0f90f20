// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/close_loops.h"

#include <algorithm>
#include <set>
#include <utility>

#include "stages/graph/pose_graph/drift_gate.h"
#include "stages/graph/pose_graph/join_runs.h"
#include "stages/graph/pose_graph/sensor_graphs.h"

namespace nightmap {
namespace {

// Mahalanobis distance in the graph beyond which a loop is rejected.
constexpr double kMaxLoopError = 6.0;

// By the keyframe after each.
std::set<int> Bridges(const std::vector<PoseEdge>& tree) {
  std::set<int> bridges;
  for (const PoseEdge& edge : tree) {
    if (edge.is_bridge) bridges.insert(edge.frame_b);
  }
  return bridges;
}

}  // namespace

LoopCloser::LoopCloser(const PoseGraphOptions& options,
                       const OdometryChain& chain,
                       const std::vector<std::optional<PoseEdge>>& loops,
                       std::vector<PoseEdge> measured)
    : options_(options), chain_(chain), measured_(std::move(measured)) {
  for (const auto& loop : loops) candidates_.push_back({loop, 0, 0, ""});
}

GraduationSummary LoopCloser::Close(std::map<int, Rigid3>* graph_from_keyframe) {
  GateByDrift(graph_from_keyframe);
  AddMeasured();
  MoveToPriors(graph_from_keyframe);
  GraduationSummary summary = OptimizeGraph(kMaxLoopError, &edges_, graph_from_keyframe);
  graph_from_keyframe->erase(kMapNode);
  Judge();
  return summary;
}

// Keeps the loops that the odometry's drift allows; then again, after the runs moved to where the
// loops put them.
void LoopCloser::GateByDrift(std::map<int, Rigid3>* graph_from_keyframe) {
  const DriftGate by_odometry(chain_.edges);
  std::vector<PoseEdge> possible;
  for (LoopCandidate& loop : candidates_) {
    if (loop.edge) loop.drift = by_odometry.Distance(*loop.edge);
    if (loop.edge && loop.drift <= options_.max_drift) possible.push_back(*loop.edge);
  }
  const std::vector<PoseEdge> tree = JoinRuns(chain_.edges, possible, options_.max_drift);
  const DriftGate gate(tree);
  const Rigid3 first = graph_from_keyframe->begin()->second;
  for (const auto& [idx, pose] : gate.Poses()) graph_from_keyframe->at(idx) = first * pose;
  const std::set<int> bridges = Bridges(tree);
  for (const PoseEdge& edge : chain_.edges) {
    if (!edge.is_bridge || bridges.contains(edge.frame_b)) edges_.push_back({edge, false});
  }
  for (LoopCandidate& loop : candidates_) {
    if (!loop.edge) continue;
    loop.drift = std::max(loop.drift, gate.Distance(*loop.edge));
    if (loop.drift <= options_.max_drift) edges_.push_back({*loop.edge, true});
  }
}

void LoopCloser::AddMeasured() {
  for (const PoseEdge& edge : measured_) {
    edges_.push_back({edge, false});
    edges_.back().is_of_sensor = true;
  }
}

// The map comes before all keyframes, so that optimization holds it fixed.
void LoopCloser::MoveToPriors(std::map<int, Rigid3>* graph_from_keyframe) const {
  const auto prior = std::ranges::find(measured_, kMapNode, &PoseEdge::frame_a);
  if (prior == measured_.end()) return;
  const Rigid3 map_from_graph =
      (graph_from_keyframe->at(prior->frame_b) * prior->b_from_a).Inverse();
  for (auto& [idx, pose] : *graph_from_keyframe) pose = map_from_graph * pose;
  graph_from_keyframe->emplace(kMapNode, Rigid3());
}

void LoopCloser::Judge() {
  auto edge = std::ranges::find_if(edges_, &GraphEdge::is_loop);
  for (LoopCandidate& loop : candidates_) {
    if (!loop.edge) {
      loop.reason = "both ends are one keyframe";
    } else if (loop.drift > options_.max_drift) {
      loop.reason = "farther off than the odometry can have drifted";
    } else {
      loop.error = edge->error;
      if (!edge->IsBelieved()) loop.reason = "contradicts the rest of the graph";
      ++edge;
    }
  }
}

}  // namespace nightmap
