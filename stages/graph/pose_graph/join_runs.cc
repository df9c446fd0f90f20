// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/join_runs.h"

#include <algorithm>
#include <map>
#include <utility>

#include "pipeline/base/union_find.h"
#include "stages/graph/pose_graph/drift_gate.h"

namespace nightmap {
namespace {

constexpr int kMinSupport = 3;
constexpr std::size_t kMaxHypotheses = 100;  // candidates for a join, spread over the loops

class RunJoiner {
 public:
  RunJoiner(const std::vector<PoseEdge>& odometry, double max_drift)
      : max_drift_(max_drift), runs_(odometry.size() + 1) {
    std::size_t run = 0;
    if (!odometry.empty()) run_of_[odometry[0].frame_a] = run;
    for (const PoseEdge& edge : odometry) {
      if (edge.is_bridge) ++run;
      if (!edge.is_bridge) tree_.push_back(edge);
      run_of_[edge.frame_b] = run;
    }
  }

  // Joins by the loop that most loops between the same two sets of runs agree with; false: too few
  // agree.
  bool JoinByLoops(const std::vector<PoseEdge>& loops) {
    std::vector<PoseEdge> open;
    for (const PoseEdge& loop : loops) {
      if (!IsJoined(loop)) open.push_back(loop);
    }
    const std::size_t step = open.size() / kMaxHypotheses + 1;
    int best_support = kMinSupport - 1;
    const PoseEdge* best = nullptr;
    for (std::size_t i = 0; i < open.size(); i += step) {
      const int support = Support(open[i], open);
      if (support > best_support) best = &open[i];
      best_support = std::max(best_support, support);
    }
    if (best) Join(*best);
    return best != nullptr;
  }

  void JoinByBridge(const PoseEdge& bridge) {
    if (!IsJoined(bridge)) Join(bridge);
  }

  std::vector<PoseEdge> Tree() && { return std::move(tree_); }

 private:
  std::pair<std::size_t, std::size_t> SetsOf(const PoseEdge& edge) {
    const std::size_t a = runs_.Find(run_of_.at(edge.frame_a));
    const std::size_t b = runs_.Find(run_of_.at(edge.frame_b));
    return {std::min(a, b), std::max(a, b)};
  }
  bool IsJoined(const PoseEdge& edge) {
    const auto [a, b] = SetsOf(edge);
    return a == b;
  }

  int Support(const PoseEdge& hypothesis, const std::vector<PoseEdge>& open) {
    tree_.push_back(hypothesis);
    const DriftGate gate(tree_);
    tree_.pop_back();
    const auto joined = SetsOf(hypothesis);
    return static_cast<int>(std::ranges::count_if(open, [&](const PoseEdge& loop) {
      return SetsOf(loop) == joined && gate.Distance(loop) <= max_drift_;
    }));
  }

  void Join(const PoseEdge& edge) {
    runs_.Join(run_of_.at(edge.frame_a), run_of_.at(edge.frame_b));
    tree_.push_back(edge);
  }

  double max_drift_;
  std::map<int, std::size_t> run_of_;  // by keyframe
  UnionFind runs_;
  std::vector<PoseEdge> tree_;
};

}  // namespace

std::vector<PoseEdge> JoinRuns(const std::vector<PoseEdge>& odometry,
                               const std::vector<PoseEdge>& loops,
                               double max_drift) {
  RunJoiner joiner(odometry, max_drift);
  while (joiner.JoinByLoops(loops)) {
  }
  for (const PoseEdge& edge : odometry) {
    if (edge.is_bridge) joiner.JoinByBridge(edge);
  }
  return std::move(joiner).Tree();
}

}  // namespace nightmap
