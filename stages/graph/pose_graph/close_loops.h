// SPDX-License-Identifier: Apache-2.0
// Closes loops: keeps those that the odometry's drift allows, and optimizes the graph in which
// those that contradict the rest lose their weight.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/graph/odometry_chain.h"
#include "stages/graph/pose_graph/optimize_graph.h"

namespace nightmap {

// A loop on its way into the graph.
struct LoopCandidate {
  std::optional<PoseEdge> edge;  // between keyframes; none: both ends are one, or not verified
  double drift = 0;              // Mahalanobis distance from the odometry; 0 without an edge
  double error = 0;    // Mahalanobis distance after optimization; 0 when it never entered the graph
  std::string reason;  // why it is not accepted; empty when accepted
};

class LoopCloser {
 public:
  // `chain` must outlive this. `measured` are odometry between keyframes and priors of keyframes,
  // of other sensors: they are believed.
  LoopCloser(const PoseGraphOptions& options,
             const OdometryChain& chain,
             const std::vector<std::optional<PoseEdge>>& loops,
             std::vector<PoseEdge> measured);

  // Moves the keyframes to where the loops put them, closes the loops, and judges them. With a
  // prior the graph's frame becomes the map of the priors.
  GraduationSummary Close(std::map<int, Rigid3>* graph_from_keyframe);

  // After Close. In the order of `loops`.
  const std::vector<LoopCandidate>& Candidates() const { return candidates_; }
  // After Close. Odometry without the bridges that loops replace, then the loops that the drift
  // allows, then what other sensors measured.
  const std::vector<GraphEdge>& Edges() const { return edges_; }

 private:
  void GateByDrift(std::map<int, Rigid3>* graph_from_keyframe);
  void AddMeasured();
  // One prior decides where optimization begins: from a guess that is far off it would not arrive.
  void MoveToPriors(std::map<int, Rigid3>* graph_from_keyframe) const;
  void Judge();

  const PoseGraphOptions& options_;
  const OdometryChain& chain_;
  std::vector<LoopCandidate> candidates_;
  std::vector<PoseEdge> measured_;
  std::vector<GraphEdge> edges_;
};

}  // namespace nightmap
