// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/pose_graph.h"

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/median.h"
#include "pipeline/graph/frame_poses.h"
#include "stages/graph/pose_graph/chain_odometry.h"
#include "stages/graph/pose_graph/check_odometry.h"
#include "stages/graph/pose_graph/close_loops.h"
#include "stages/graph/pose_graph/correct_edges.h"
#include "stages/graph/pose_graph/fill_bridges.h"
#include "stages/graph/pose_graph/graph_parts.h"
#include "stages/graph/pose_graph/sensor_graphs.h"
#include "stages/graph/pose_graph/sensor_warnings.h"

namespace nightmap {
namespace {

class Pipeline {
 public:
  Pipeline(const PoseGraphOptions& options, const PoseGraphInput& input)
      : options_(options), input_(input), sensors_(MakeSensorGraphs(input)) {
    graph_.floor = options.edge_sigma_floor;
    graph_.chain = ChainOdometry(options, input);
    CalibrateSensors();
    graph_.filled = FillBridges(graph_.floor, sensors_, &graph_.chain);
    for (const int idx : graph_.chain.keyframes) {
      graph_.graph_from_keyframe[idx] = graph_.chain.At(idx);
    }
  }

  PoseGraphResult Run(Progress& progress) {
    progress.Start(2);
    const std::vector<GraphEdge> edges = CloseLoops();
    progress.Advance();
    result_.parts = FindParts(edges, GraphNodes(), static_cast<int>(input_.frames.size()));
    result_.returns_to_start = ReturnsToStart(edges, graph_.chain.keyframes);
    result_.graph_from_camera = CarryFrames(graph_.chain, graph_.graph_from_keyframe);
    NoteBelieved(edges);
    RecordSensors();
    result_.graph = std::move(graph_);
    progress.Advance();
    return std::move(result_);
  }

 private:
  // The camera's odometry alone decides: a trajectory that follows the sensors too leans to their
  // error.
  void CalibrateSensors() {
    if (sensors_.empty()) return;
    const std::vector<CameraRun> runs = FindCameraRuns(input_.frames, graph_.chain);
    for (SensorGraph& sensor : sensors_) {
      const auto calibration = CalibrateSensor(graph_.floor, runs, sensor);
      calibrations_.push_back(calibration);
      if (!calibration || !options_.calibrate_sensors) continue;
      CorrectEdges(options_.calibration_warnings, input_.frames, runs, *calibration, &sensor);
    }
  }

  std::vector<GraphEdge> CloseLoops() {
    const OdometryChain& chain = graph_.chain;
    std::vector<std::optional<PoseEdge>> loops;
    for (const CountedPair& loop : input_.loops) {
      loops.push_back(LoopAtKeyframes(graph_.floor, chain, chain.keyframes, loop));
    }
    for (const SensorGraph& sensor : sensors_) {
      for (const PoseEdge& loop : sensor.loops) {
        loops.push_back(AtKeyframes(graph_.floor, chain, chain.keyframes, loop));
      }
    }
    LoopCloser closer(
        options_,
        chain,
        loops,
        MeasuredBySensors(graph_.floor, chain, chain.keyframes, sensors_, graph_.filled));
    result_.optimization = closer.Close(&graph_.graph_from_keyframe);
    for (std::size_t i = 0; i < input_.loops.size(); ++i) {
      RecordLoop(input_.loops[i], closer.Candidates()[i]);
    }
    RecordSensorLoops(closer.Candidates());
    KeepAcceptedLoops(closer.Candidates());
    return closer.Edges();
  }

  // The candidates of the sensors follow those of the camera.
  void KeepAcceptedLoops(const std::vector<LoopCandidate>& candidates) {
    graph_.sensors = sensors_;
    std::size_t i = input_.loops.size();
    for (SensorGraph& sensor : graph_.sensors) {
      std::erase_if(sensor.loops, [&](const PoseEdge&) { return !candidates[i++].reason.empty(); });
    }
  }

  void RecordLoop(const CountedPair& loop, const LoopCandidate& candidate) {
    const bool is_verified = loop.status == PairStatus::kAccepted;
    const std::string reason = is_verified ? candidate.reason : PairStatusText(loop.status);
    result_.loops.push_back({loop.frame_a,
                             loop.frame_b,
                             loop.score,
                             loop.num_putative,
                             loop.num_inliers,
                             candidate.drift,
                             candidate.error,
                             reason.empty(),
                             reason});
    graph_.is_loop_accepted.push_back(reason.empty());
  }

  void RecordSensorLoops(const std::vector<LoopCandidate>& candidates) {
    std::size_t i = input_.loops.size();
    for (const SensorGraph& sensor : sensors_) {
      for (const PoseEdge& loop : sensor.loops) {
        const LoopCandidate& candidate = candidates[i++];
        result_.loops.push_back({.frame_a = loop.frame_a,
                                 .frame_b = loop.frame_b,
                                 .drift = candidate.drift,
                                 .error = candidate.error,
                                 .is_accepted = candidate.reason.empty(),
                                 .reason = candidate.reason});
      }
    }
  }

  // With the map, where priors hold keyframes in it.
  std::set<int> GraphNodes() const {
    std::set<int> nodes = graph_.chain.keyframes;
    nodes.insert(kMapNode);
    return nodes;
  }

  void NoteBelieved(const std::vector<GraphEdge>& edges) {
    for (const GraphEdge& edge : edges) {
      if (edge.IsBelieved() && edge.edge.frame_a != kMapNode) result_.edges.push_back(edge.edge);
    }
    for (const PoseEdge& edge : graph_.chain.edges) {
      if (edge.is_bridge) graph_.replaced_bridges.insert(edge.frame_b);
    }
    for (const PoseEdge& edge : result_.edges) {
      if (edge.is_bridge) graph_.replaced_bridges.erase(edge.frame_b);
    }
  }

  void RecordSensors() {
    for (std::size_t i = 0; i < sensors_.size(); ++i) {
      const SensorGraph& all = sensors_[i];
      std::vector<PoseEdge> kept = all.odometry;
      for (const PoseEdge& loop : graph_.sensors[i].loops) kept.push_back(loop);
      for (const PoseEdge& prior : all.priors) {
        if (AtKeyframes(graph_.floor, graph_.chain, graph_.chain.keyframes, prior)) {
          kept.push_back(prior);
        }
      }
      const std::size_t num_edges = all.odometry.size() + all.loops.size() + all.priors.size();
      result_.sensors.push_back({all.sensor,
                                 static_cast<int>(all.odometry.size()),
                                 static_cast<int>(all.loops.size()),
                                 static_cast<int>(all.priors.size()),
                                 static_cast<int>(num_edges - kept.size()),
                                 MedianResidual(kept),
                                 calibrations_[i],
                                 {}});
      if (!calibrations_[i]) continue;
      result_.sensors.back().warnings =
          WarningsOf(options_.calibration_warnings, all.sensor, *calibrations_[i]);
    }
  }

  double MedianResidual(const std::vector<PoseEdge>& edges) const {
    const auto pose = [&](int node) {
      return node == kMapNode ? Rigid3()
                              : result_.graph_from_camera[static_cast<std::size_t>(node)];
    };
    std::vector<double> residuals;
    for (const PoseEdge& edge : edges) {
      residuals.push_back(ErrorOf(edge, pose(edge.frame_a), pose(edge.frame_b)));
    }
    return Median(std::move(residuals));
  }

  const PoseGraphOptions& options_;
  const PoseGraphInput& input_;
  std::vector<SensorGraph> sensors_;                            // with all their loops
  std::vector<std::optional<SensorCalibration>> calibrations_;  // of sensors_
  ClosedGraph graph_;
  PoseGraphResult result_;
};

void CheckConnection(const PoseGraphOptions& options, const PoseGraphResult& result) {
  const auto num_frames = static_cast<double>(result.graph_from_camera.size());
  const int num_connected = result.parts.empty() ? 0 : result.parts.front().num_frames;
  if (num_connected >= options.min_connected_ratio * num_frames) return;
  throw ThresholdError(
      "measured motion connects {} of {} frames, fewer than min_connected_ratio = {}: this is no "
      "map. "
      "Check fx, fy, cx, cy and depth_units_per_m of the [[camera]], that depth belongs to its "
      "color "
      "picture, and the order of the frames; make check looks at most of it",
      num_connected,
      result.graph_from_camera.size(),
      options.min_connected_ratio);
}

}  // namespace

PoseGraphResult RunPoseGraph(const PoseGraphOptions& options,
                             const PoseGraphInput& input,
                             Progress& progress) {
  CheckInput(input);
  PoseGraphResult result = Pipeline(options, input).Run(progress);
  CheckConnection(options, result);
  return result;
}

}  // namespace nightmap
