// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/join_runs.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>
#include <utility>

#include "stages/graph/pose_graph/drift_gate.h"

namespace nightmap {
namespace {

constexpr std::size_t kMinSupport = 3;
constexpr std::size_t kMaxHypotheses = 100;  // candidates for a join, spread over the loops

std::vector<PoseEdge> WithoutBridges(std::vector<PoseEdge> odometry) {
  std::erase_if(odometry, [](const PoseEdge& edge) { return edge.is_bridge; });
  return odometry;
}

class RunJoiner {
 public:
  RunJoiner(const std::vector<PoseEdge>& odometry,
            const std::vector<PoseEdge>& loops,
            double max_drift)
      : max_drift_(max_drift), gate_(WithoutBridges(odometry), odometry) {
    for (const PoseEdge& loop : loops) open_.push_back(&loop);
  }

  // Joins by the loop that most loops between the same two sets of runs agree with; false: too few
  // agree.
  bool JoinByLoops() {
    std::erase_if(open_, [&](const PoseEdge* loop) { return IsJoined(*loop); });
    const auto rivals = OpenByTrees();
    const std::size_t step = open_.size() / kMaxHypotheses + 1;
    std::size_t best_support = kMinSupport - 1;
    const PoseEdge* best = nullptr;
    for (std::size_t i = 0; i < open_.size(); i += step) {
      const Loops& same = rivals.at(gate_.TreesOf(*open_[i]));
      if (same.size() <= best_support) continue;
      if (const auto support = LargerSupport(*open_[i], same, best_support)) {
        best = open_[i];
        best_support = *support;
      }
    }
    if (best) gate_.Join(*best);
    return best != nullptr;
  }

  void JoinByBridge(const PoseEdge& bridge) {
    if (!IsJoined(bridge)) gate_.Join(bridge);
  }

  std::vector<PoseEdge> Tree() && { return std::move(gate_).TakeTree(); }

 private:
  using Loops = std::vector<const PoseEdge*>;

  bool IsJoined(const PoseEdge& edge) const {
    const auto [a, b] = gate_.TreesOf(edge);
    return a == b;
  }

  std::map<std::pair<std::size_t, std::size_t>, Loops> OpenByTrees() const {
    std::map<std::pair<std::size_t, std::size_t>, Loops> loops;
    for (const PoseEdge* loop : open_) loops[gate_.TreesOf(*loop)].push_back(loop);
    return loops;
  }

  // How many loops agree, if more than `least` do.
  std::optional<std::size_t> LargerSupport(const PoseEdge& hypothesis,
                                           const Loops& loops,
                                           std::size_t least) const {
    const JoinedTrees joined(gate_, hypothesis);
    std::size_t may_agree = loops.size();
    for (const PoseEdge* loop : loops) {
      if (joined.Distance(*loop) <= max_drift_) continue;
      if (--may_agree <= least) return std::nullopt;
    }
    return may_agree;
  }

  double max_drift_;
  DriftGate gate_;  // a tree for each set of joined runs
  Loops open_;      // between two of them
};

}  // namespace

std::vector<PoseEdge> JoinRuns(const std::vector<PoseEdge>& odometry,
                               const std::vector<PoseEdge>& loops,
                               double max_drift) {
  RunJoiner joiner(odometry, loops, max_drift);
  while (joiner.JoinByLoops()) {
  }
  for (const PoseEdge& edge : odometry) {
    if (edge.is_bridge) joiner.JoinByBridge(edge);
  }
  return std::move(joiner).Tree();
}

}  // namespace nightmap
