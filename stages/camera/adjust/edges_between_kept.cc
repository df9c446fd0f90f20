// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/adjust/edges_between_kept.h"

#include <optional>

namespace nightmap {
namespace {

std::vector<PoseEdge> OdometryPast(const ClosedGraph& graph, const std::set<int>& kept) {
  std::vector<PoseEdge> edges;
  for (const PoseEdge& edge : graph.chain.edges) {
    if (graph.replaced_bridges.contains(edge.frame_b)) continue;
    if (kept.contains(edge.frame_a)) {
      edges.push_back(edge);
    } else {
      edges.back() = Chained(edges.back(), edge);
    }
  }
  return edges;
}

}  // namespace

std::vector<PoseEdge> EdgesBetweenKept(const ClosedGraph& graph,
                                       const std::vector<FramePair>& loops,
                                       const std::set<int>& kept) {
  std::vector<PoseEdge> edges = OdometryPast(graph, kept);
  const auto add = [&](const std::optional<PoseEdge>& edge) {
    if (edge && edge->frame_a != kMapNode) edges.push_back(*edge);
  };
  for (std::size_t i = 0; i < loops.size(); ++i) {
    if (!graph.is_loop_accepted[i]) continue;
    add(LoopAtKeyframes(graph.floor, graph.chain, kept, loops[i]));
  }
  for (const PoseEdge& edge :
       MeasuredBySensors(graph.floor, graph.chain, kept, graph.sensors, graph.filled)) {
    add(edge);
  }
  for (const SensorGraph& sensor : graph.sensors) {
    for (const PoseEdge& loop : sensor.loops)
      add(AtKeyframes(graph.floor, graph.chain, kept, loop));
  }
  return edges;
}

}  // namespace nightmap
