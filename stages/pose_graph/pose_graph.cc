// SPDX-License-Identifier: Apache-2.0
#include "stages/pose_graph/pose_graph.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "stages/pose_graph/adjust_rounds.h"
#include "stages/pose_graph/check_odometry.h"
#include "stages/pose_graph/close_loops.h"
#include "stages/pose_graph/cull_keyframes.h"
#include "stages/pose_graph/graph_parts.h"
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
    progress.Start(3);
    CloseLoops();
    progress.Advance();
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
  // A loop joins two frames; its edge joins their nearest keyframes.
  std::optional<PoseEdge> LoopEdge(const std::set<int>& keyframes, const FramePair& loop) const {
    if (loop.status != PairStatus::kAccepted) return std::nullopt;
    const auto edge = JoinKeyframes(
        chain_, keyframes, {loop.frame_a, loop.frame_b, loop.b_from_a, loop.covariance, false});
    if (!edge) return std::nullopt;
    return WithSigmaFloor(options_, *edge);
  }

  void CloseLoops() {
    const std::set<int> keyframes = KeyframeIdxs();
    std::vector<std::optional<PoseEdge>> loops;
    for (const FramePair& loop : input_.loops) loops.push_back(LoopEdge(keyframes, loop));
    LoopCloser closer(options_, chain_, loops);
    result_.optimization = closer.Close(&keyframes_);
    edges_ = closer.Edges();
    for (std::size_t i = 0; i < input_.loops.size(); ++i) {
      RecordLoop(input_.loops[i], closer.Candidates()[i]);
    }
  }

  void RecordLoop(const FramePair& loop, const LoopCandidate& candidate) {
    const bool is_verified = loop.status == PairStatus::kAccepted;
    const std::string reason = is_verified ? candidate.reason : PairStatusText(loop.status);
    result_.loops.push_back({loop.frame_a,
                             loop.frame_b,
                             loop.score,
                             loop.num_putative,
                             static_cast<int>(loop.inliers.size()),
                             candidate.drift,
                             candidate.error,
                             reason.empty(),
                             reason});
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
    const std::set<int> keyframes = KeyframeIdxs();
    for (std::size_t i = 0; i < input_.loops.size(); ++i) {
      if (!result_.loops[i].is_accepted) continue;
      if (const auto edge = LoopEdge(keyframes, input_.loops[i])) edges.push_back({*edge, true});
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
