// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/graph_parts.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <map>
#include <utility>

#include "pipeline/base/union_find.h"

namespace nightmap {
namespace {

// Index of each keyframe among all.
std::map<int, std::size_t> Places(const std::set<int>& keyframes) {
  std::map<int, std::size_t> places;
  for (const int idx : keyframes) places.emplace(idx, places.size());
  return places;
}

}  // namespace

std::vector<GraphPart> FindParts(const std::vector<GraphEdge>& edges,
                                 const std::set<int>& keyframes,
                                 int num_frames) {
  const std::map<int, std::size_t> places = Places(keyframes);
  UnionFind sets(places.size());
  for (const GraphEdge& edge : edges) {
    if (edge.edge.is_bridge || !edge.IsBelieved()) continue;
    sets.Join(places.at(edge.edge.frame_a), places.at(edge.edge.frame_b));
  }
  std::map<std::size_t, GraphPart> by_root;
  for (int idx = 0; idx < num_frames; ++idx) {
    GraphPart& part = by_root[sets.Find(std::prev(places.upper_bound(idx))->second)];
    ++part.num_frames;
    if (part.runs.empty() || part.runs.back().second + 1 < idx) part.runs.push_back({idx, idx});
    part.runs.back().second = idx;
  }
  std::vector<GraphPart> parts;
  for (auto& [root, part] : by_root) parts.push_back(std::move(part));
  std::ranges::stable_sort(parts, std::greater<>(), &GraphPart::num_frames);
  return parts;
}

bool ReturnsToStart(const std::vector<GraphEdge>& edges, const std::set<int>& keyframes) {
  const std::map<int, std::size_t> places = Places(keyframes);
  return std::ranges::any_of(edges, [&](const GraphEdge& edge) {
    return edge.is_loop && !edge.edge.is_bridge && edge.IsBelieved() &&
           10 * places.at(edge.edge.frame_a) < places.size() &&
           10 * places.at(edge.edge.frame_b) >= 9 * places.size();
  });
}

}  // namespace nightmap
