// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/sensor_graphs.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "pipeline/base/input_error.h"

namespace nightmap {
namespace {

class SensorGraphMaker {
 public:
  explicit SensorGraphMaker(const PoseGraphInput& input) {
    for (const FrameRecord& frame : input.frames) {
      frame_at_.emplace(frame.time_ns, frame.frame_idx);
      num_cameras_ = std::max(num_cameras_, static_cast<std::size_t>(frame.camera_idx) + 1);
    }
    for (std::size_t i = 0; i < input.edges.size(); ++i) Add(i, input.edges[i]);
  }

  std::vector<SensorGraph> Take() && {
    for (SensorGraph& graph : graphs_) {
      std::ranges::stable_sort(graph.odometry, {}, &PoseEdge::frame_a);
      CheckAscends(graph);
    }
    return std::move(graphs_);
  }

 private:
  void Add(std::size_t file_idx, const SensorEdges& file) {
    SensorGraph& graph = GraphOf(file.sensor);
    CheckMounting(file_idx, file);
    if (!graph.mounting) graph.mounting = file.mounting;
    for (const SensorEdge& edge : file.edges) {
      const int source = FrameAt(file_idx, edge.source_time_ns);
      const int target = FrameAt(file_idx, edge.target_time_ns);
      const PoseEdge between{source, target, edge.target_from_source, edge.covariance, false};
      if (edge.kind == EdgeKind::kPrior) {
        graph.priors.push_back(FromMap(between));
      } else if (edge.kind == EdgeKind::kLoop) {
        graph.loops.push_back(source < target ? between : Inverse(between));
      } else {
        graph.odometry.push_back(between);
      }
    }
  }

  void CheckMounting(std::size_t file_idx, const SensorEdges& file) const {
    if (!file.mounting || file.mounting->robot_from_camera.size() >= num_cameras_) return;
    throw InputError({{"edges", file_idx}},
                     "it has robot_from_camera of {} cameras, but the frames are of {}",
                     file.mounting->robot_from_camera.size(),
                     num_cameras_);
  }

  static void CheckAscends(const SensorGraph& graph) {
    int end = 0;
    for (const PoseEdge& edge : graph.odometry) {
      if (edge.frame_a < end || edge.frame_b <= edge.frame_a) {
        throw InputError(
            {{"edges"}},
            "the odometry of sensor '{}' between frames {} and {} overlaps that before "
            "it, or leads from one recording to another",
            graph.sensor,
            edge.frame_a,
            edge.frame_b);
      }
      end = edge.frame_b;
    }
  }

  SensorGraph& GraphOf(const std::string& sensor) {
    const auto found = std::ranges::find(graphs_, sensor, &SensorGraph::sensor);
    if (found != graphs_.end()) return *found;
    return graphs_.emplace_back(SensorGraph{sensor, {}, {}, {}});
  }

  int FrameAt(std::size_t file_idx, std::int64_t time_ns) const {
    const auto found = frame_at_.find(time_ns);
    if (found != frame_at_.end()) return found->second;
    throw InputError(
        {{"edges", file_idx}}, "an edge has node time_ns {}, at which there is no frame", time_ns);
  }

  // A prior's perturbation turns about the node, not about the map's origin, so only axes change.
  static PoseEdge FromMap(const PoseEdge& prior) {
    const Rigid3 camera_from_map = prior.b_from_a.Inverse();
    const Matrix6d turn = Adjoint({camera_from_map.rotation, Eigen::Vector3d::Zero()});
    return {kMapNode,
            prior.frame_a,
            camera_from_map,
            turn * prior.covariance * turn.transpose(),
            false};
  }

  static PoseEdge Inverse(const PoseEdge& edge) {
    const Rigid3 a_from_b = edge.b_from_a.Inverse();
    const Matrix6d adjoint = Adjoint(a_from_b);
    return {edge.frame_b,
            edge.frame_a,
            a_from_b,
            adjoint * edge.covariance * adjoint.transpose(),
            false};
  }

  std::unordered_map<std::int64_t, int> frame_at_;
  std::size_t num_cameras_ = 0;
  std::vector<SensorGraph> graphs_;
};

}  // namespace

std::vector<SensorGraph> MakeSensorGraphs(const PoseGraphInput& input) {
  return SensorGraphMaker(input).Take();
}

}  // namespace nightmap
