// SPDX-License-Identifier: Apache-2.0
#include "stages/pose_graph/pose_graph.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "stages/pose_graph/adjust_rounds.h"
#include "stages/pose_graph/check_odometry.h"
#include "stages/pose_graph/cull_keyframes.h"
#include "stages/pose_graph/drift_gate.h"
#include "stages/pose_graph/graph_parts.h"
#include "stages/pose_graph/join_runs.h"
#include "stages/pose_graph/odometry_chain.h"

namespace nightmap {
namespace {

class Pipeline {
 public:
  Pipeline(const PoseGraphOptions& options, const PoseGraphInput& input, int num_threads)
      : options_(options),
        input_(input),
        chain_(ChainOdometry(options, input)),
        rounds_(options, input, chain_, num_threads) {
    result_.is_keyframe.assign(input.frames.size(), false);
    for (const int idx : chain_.keyframes) {
      keyframes_[idx] = chain_.At(idx);
      result_.is_keyframe[static_cast<std::size_t>(idx)] = true;
    }
  }

  PoseGraphResult Run(Progress& progress) {
    progress.Start(4);
    AddLoops();
    progress.Advance();
    result_.optimization = OptimizeGraph(options_.max_loop_error, &edges_, &keyframes_);
    JudgeLoops();
    result_.parts = FindParts(edges_, KeyframeIdxs(), static_cast<int>(input_.frames.size()));
    result_.returns_to_start = ReturnsToStart(edges_, KeyframeIdxs());
    progress.Advance();
    auto tracks = MergeTracks(input_.odometry, input_.loops, AcceptedLoops(), KeyframeIdxs());
    const auto redundant =
        RedundantKeyframes(tracks, KeyframeIdxs(), BridgeEnds(), options_.max_seen_ratio);
    Cull(redundant);
    if (options_.bundle_adjustment) {
      Note(rounds_.AdjustKeyframes(WithoutFrames(std::move(tracks), redundant), &keyframes_));
    }
    result_.graph_from_camera = rounds_.CarryFrames(keyframes_);
    if (options_.bundle_adjustment && options_.final_adjustment) {
      Note(rounds_.AdjustDescribed(&keyframes_, &result_.graph_from_camera));
    }
    progress.Advance();
    FillGraph();
    return std::move(result_);
  }

 private:
  int KeyframeAtOrBefore(int frame_idx) const {
    return std::prev(keyframes_.upper_bound(frame_idx))->first;
  }
  // Does not cross a bridge, because odometry did not measure that motion.
  int NearestKeyframe(int frame_idx) const {
    const int before = KeyframeAtOrBefore(frame_idx);
    const auto after = keyframes_.lower_bound(frame_idx);
    if (after == keyframes_.end() || chain_.IsBridged(before, after->first)) return before;
    return after->first - frame_idx < frame_idx - before ? after->first : before;
  }

  // A loop joins two frames; its edge joins their nearest keyframes.
  std::optional<PoseEdge> LoopEdge(const FramePair& loop) {
    const int a = NearestKeyframe(loop.frame_a);
    const int b = NearestKeyframe(loop.frame_b);
    if (loop.status != PairStatus::kAccepted || a >= b) return std::nullopt;
    const Rigid3 b_from_a = chain_.At(b).Inverse() * chain_.At(loop.frame_b) * loop.b_from_a *
                            chain_.At(loop.frame_a).Inverse() * chain_.At(a);
    return WithSigmaFloor(options_, {a, b, b_from_a, loop.covariance, false});
  }

  // Keeps the loops that the odometry's drift allows; then again, after the runs moved to where the
  // loops put them.
  void AddLoops() {
    std::vector<std::optional<PoseEdge>> loops;
    for (const FramePair& loop : input_.loops) loops.push_back(LoopEdge(loop));
    const DriftGate by_odometry(chain_.edges);
    std::vector<PoseEdge> possible;
    for (const auto& loop : loops) {
      if (loop && by_odometry.Distance(*loop) <= options_.max_drift) possible.push_back(*loop);
    }
    const std::vector<PoseEdge> tree = JoinRuns(chain_.edges, possible, options_.max_drift);
    const DriftGate gate(tree);
    const Rigid3 first = keyframes_.begin()->second;
    for (const auto& [idx, pose] : gate.Poses()) keyframes_.at(idx) = first * pose;
    for (const PoseEdge& edge : chain_.edges) {
      if (!edge.is_bridge || IsIn(tree, edge)) edges_.push_back({edge, false});
    }
    for (const auto& loop : loops) {
      drifts_.push_back(loop ? std::max(by_odometry.Distance(*loop), gate.Distance(*loop)) : 0);
      const bool is_possible = loop && drifts_.back() <= options_.max_drift;
      loop_edge_.push_back(is_possible ? static_cast<int>(edges_.size()) : -1);
      if (is_possible) edges_.push_back({*loop, true});
    }
  }

  static bool IsIn(const std::vector<PoseEdge>& tree, const PoseEdge& bridge) {
    return std::ranges::any_of(tree, [&](const PoseEdge& edge) {
      return edge.is_bridge && edge.frame_b == bridge.frame_b;
    });
  }

  void JudgeLoops() {
    for (std::size_t i = 0; i < input_.loops.size(); ++i) {
      const FramePair& loop = input_.loops[i];
      LoopRecord record{loop.frame_a,
                        loop.frame_b,
                        loop.score,
                        loop.num_putative,
                        static_cast<int>(loop.inliers.size()),
                        drifts_[i],
                        0,
                        false,
                        ""};
      if (loop.status != PairStatus::kAccepted) {
        record.reason = PairStatusText(loop.status);
      } else if (drifts_[i] > options_.max_drift) {
        record.reason = "farther off than the odometry can have drifted";
      } else if (loop_edge_[i] < 0) {
        record.reason = "both ends are one keyframe";
      } else {
        const GraphEdge& edge = edges_[static_cast<std::size_t>(loop_edge_[i])];
        record.error = edge.error;
        record.is_accepted = edge.IsBelieved();
        if (!record.is_accepted) record.reason = "contradicts the rest of the graph";
      }
      result_.loops.push_back(record);
    }
  }

  void Note(const GlobalBundleSummary& summary) {
    result_.bundle_rms_px = summary.rms_px;
    result_.num_bundle_observations = summary.num_observations;
    result_.calibrations = summary.calibrations;
    result_.adjustments.insert(
        result_.adjustments.end(), summary.adjustments.begin(), summary.adjustments.end());
  }

  std::vector<bool> AcceptedLoops() const {
    std::vector<bool> is_accepted;
    for (const LoopRecord& loop : result_.loops) is_accepted.push_back(loop.is_accepted);
    return is_accepted;
  }

  std::set<int> KeyframeIdxs() const {
    std::set<int> idxs;
    for (const auto& [idx, pose] : keyframes_) idxs.insert(idx);
    return idxs;
  }

  std::set<int> BridgeEnds() const {
    std::set<int> ends;
    for (const PoseEdge& edge : chain_.edges) {
      if (edge.is_bridge) ends.insert({edge.frame_a, edge.frame_b});
    }
    return ends;
  }

  // Edges of odometry bypass a dropped keyframe; loops move to the keyframe that is nearest now.
  void Cull(const std::set<int>& redundant) {
    for (const int idx : redundant) {
      keyframes_.erase(idx);
      result_.is_keyframe[static_cast<std::size_t>(idx)] = false;
    }
    result_.num_culled = static_cast<int>(redundant.size());
    std::vector<GraphEdge> edges;
    for (const GraphEdge& edge : edges_) {
      if (edge.is_loop) continue;
      const bool goes_on = redundant.contains(edge.edge.frame_a);
      edges.push_back({goes_on ? Chain(edges.back().edge, edge.edge) : edge.edge, false});
      if (goes_on) edges.erase(edges.end() - 2);
    }
    for (std::size_t i = 0; i < input_.loops.size(); ++i) {
      if (!result_.loops[i].is_accepted) continue;
      if (const auto edge = LoopEdge(input_.loops[i])) edges.push_back({*edge, true});
    }
    edges_ = std::move(edges);
  }

  static PoseEdge Chain(const PoseEdge& first, const PoseEdge& second) {
    const Matrix6d adjoint = Adjoint(second.b_from_a);
    return {first.frame_a,
            second.frame_b,
            second.b_from_a * first.b_from_a,
            second.covariance + adjoint * first.covariance * adjoint.transpose(),
            false};
  }

  void FillGraph() {
    for (const auto& [idx, pose] : keyframes_) result_.graph.vertices.push_back({idx, pose});
    for (const GraphEdge& edge : edges_) {
      if (edge.IsBelieved()) result_.graph.edges.push_back(edge.edge);
    }
  }

  const PoseGraphOptions& options_;
  const PoseGraphInput& input_;
  OdometryChain chain_;
  AdjustmentRounds rounds_;
  std::map<int, Rigid3> keyframes_;  // graph_from_camera, optimized
  std::vector<GraphEdge> edges_;     // loops, and odometry without the bridges that loops replace
  std::vector<int> loop_edge_;       // by candidate; -1: none
  std::vector<double> drifts_;       // by candidate
  PoseGraphResult result_;
};

}  // namespace

PoseGraphResult RunPoseGraph(const PoseGraphOptions& options,
                             const PoseGraphInput& input,
                             int num_threads,
                             Progress& progress) {
  CheckInput(input);
  return Pipeline(options, input, num_threads).Run(progress);
}

}  // namespace nightmap
