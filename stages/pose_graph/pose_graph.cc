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
#include "stages/pose_graph/sensor_odometry.h"

namespace nightmap {
namespace {

class Pipeline {
 public:
  Pipeline(const PoseGraphOptions& options, const PoseGraphInput& input, int num_threads)
      : options_(options),
        input_(input),
        sensors_(MakeSensorGraphs(input)),
        chain_(ChainOdometry(options, input)),
        filled_(FillBridges(options, sensors_, &chain_)),
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
    result_.parts = FindParts(edges_, GraphNodes(), static_cast<int>(input_.frames.size()));
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
    RecordSensors();
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
    for (const SensorGraph& sensor : sensors_) {
      for (const PoseEdge& loop : sensor.loops) {
        loops.push_back(AtKeyframes(options_, chain_, keyframes, loop));
      }
    }
    LoopCloser closer(options_, chain_, loops, MeasuredBySensors(keyframes));
    result_.optimization = closer.Close(&keyframes_);
    edges_ = closer.Edges();
    for (std::size_t i = 0; i < input_.loops.size(); ++i) {
      RecordLoop(input_.loops[i], closer.Candidates()[i]);
    }
    for (std::size_t i = input_.loops.size(); i < loops.size(); ++i) {
      is_sensor_loop_accepted_.push_back(closer.Candidates()[i].reason.empty());
    }
  }

  std::vector<PoseEdge> MeasuredBySensors(const std::set<int>& keyframes) const {
    std::vector<PoseEdge> edges = OdometryOfSensors(options_, chain_, keyframes, sensors_, filled_);
    for (const SensorGraph& sensor : sensors_) {
      for (const PoseEdge& prior : sensor.priors) {
        if (const auto edge = AtKeyframes(options_, chain_, keyframes, prior)) {
          edges.push_back(*edge);
        }
      }
    }
    return edges;
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

  // With the map, where priors hold keyframes in it.
  std::set<int> GraphNodes() const {
    std::set<int> nodes = KeyframeIdxs();
    nodes.insert(kMapNode);
    return nodes;
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
      if (edge.is_loop || edge.is_of_sensor) continue;
      const bool goes_on = redundant.contains(edge.edge.frame_a);
      edges.push_back({goes_on ? Chained(edges.back().edge, edge.edge) : edge.edge, false});
      if (goes_on) edges.erase(edges.end() - 2);
    }
    const std::set<int> keyframes = KeyframeIdxs();
    for (std::size_t i = 0; i < input_.loops.size(); ++i) {
      if (!result_.loops[i].is_accepted) continue;
      if (const auto edge = LoopEdge(keyframes, input_.loops[i])) edges.push_back({*edge, true});
    }
    edges_ = std::move(edges);
    AddSensorEdges(keyframes);
  }

  void AddSensorEdges(const std::set<int>& keyframes) {
    for (const PoseEdge& edge : MeasuredBySensors(keyframes)) edges_.push_back({edge, false});
    std::size_t i = 0;
    for (const SensorGraph& sensor : sensors_) {
      for (const PoseEdge& loop : sensor.loops) {
        if (!is_sensor_loop_accepted_[i++]) continue;
        const auto edge = AtKeyframes(options_, chain_, keyframes, loop);
        if (edge) edges_.push_back({*edge, true});
      }
    }
  }

  void FillGraph() {
    for (const auto& [idx, pose] : keyframes_) result_.graph.vertices.push_back({idx, pose});
    for (const GraphEdge& edge : edges_) {
      const bool is_prior = edge.edge.frame_a == kMapNode;  // g2o has no vertex for the map
      if (edge.IsBelieved() && !is_prior) result_.graph.edges.push_back(edge.edge);
    }
  }

  void RecordSensors() {
    std::size_t i = 0;
    for (const SensorGraph& sensor : sensors_) {
      std::vector<PoseEdge> kept = sensor.odometry;
      for (const PoseEdge& loop : sensor.loops) {
        if (is_sensor_loop_accepted_[i++]) kept.push_back(loop);
      }
      for (const PoseEdge& prior : sensor.priors) {
        if (AtKeyframes(options_, chain_, chain_.keyframes, prior)) kept.push_back(prior);
      }
      const std::size_t num_edges =
          sensor.odometry.size() + sensor.loops.size() + sensor.priors.size();
      result_.sensors.push_back({sensor.sensor,
                                 static_cast<int>(sensor.odometry.size()),
                                 static_cast<int>(sensor.loops.size()),
                                 static_cast<int>(sensor.priors.size()),
                                 static_cast<int>(num_edges - kept.size()),
                                 MedianResidual(kept)});
    }
  }

  double MedianResidual(const std::vector<PoseEdge>& edges) const {
    if (edges.empty()) return 0;
    const auto pose = [&](int node) {
      return node == kMapNode ? Rigid3()
                              : result_.graph_from_camera[static_cast<std::size_t>(node)];
    };
    std::vector<double> residuals;
    for (const PoseEdge& edge : edges) {
      residuals.push_back(ErrorOf(edge, pose(edge.frame_a), pose(edge.frame_b)));
    }
    const auto middle = residuals.begin() + static_cast<std::ptrdiff_t>(residuals.size() / 2);
    std::ranges::nth_element(residuals, middle);
    return *middle;
  }

  const PoseGraphOptions& options_;
  const PoseGraphInput& input_;
  std::vector<SensorGraph> sensors_;
  OdometryChain chain_;
  FilledBridges filled_;
  AdjustmentRounds rounds_;
  std::map<int, Rigid3> keyframes_;  // graph_from_camera, optimized
  std::vector<GraphEdge> edges_;     // loops, and odometry without the bridges that loops replace
  std::vector<bool> is_sensor_loop_accepted_;  // of all sensors, in order
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
