// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/adopt_odometry.h"

#include <algorithm>
#include <iterator>

#include "pipeline/base/input_error.h"

namespace nightmap {
namespace {

Matrix6d BridgeCovariance() {
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(kAnywhereSigma_rad),
      Eigen::Vector3d::Constant(kAnywhereSigma_m);
  return sigma.cwiseAbs2().asDiagonal();
}

// The odometry of a file, taken out of it.
std::vector<SensorEdge> TakeOdometry(SensorEdges* file) {
  const auto first =
      std::stable_partition(file->edges.begin(), file->edges.end(), [](const SensorEdge& edge) {
        return edge.kind != EdgeKind::kOdometry;
      });
  std::vector<SensorEdge> odometry(first, file->edges.end());
  file->edges.erase(first, file->edges.end());
  return odometry;
}

// Frames and the shard of them, edge by edge.
class Adopter {
 public:
  Adopter(std::size_t file_idx, PoseGraphInput* input) : file_idx_(file_idx), input_(*input) {}

  void Adopt(const std::vector<SensorEdge>& odometry) {
    AddNode(odometry.front().source_time_ns, Rigid3());
    for (const SensorEdge& edge : odometry) {
      const std::int64_t end_ns = input_.frames.back().time_ns;
      if (edge.source_time_ns < end_ns || edge.target_time_ns <= edge.source_time_ns) {
        throw InputError({{"edges", file_idx_}},
                         "the odometry from {} ns to {} ns overlaps that before it",
                         edge.source_time_ns,
                         edge.target_time_ns);
      }
      if (edge.source_time_ns > end_ns) {
        Add(edge.source_time_ns, Rigid3(), BridgeCovariance(), true);
      }
      Add(edge.target_time_ns, edge.target_from_source, edge.covariance, false);
    }
    input_.odometry = {std::move(shard_)};
  }

 private:
  void AddNode(std::int64_t time_ns, const Rigid3& shard_from_node) {
    FrameRecord node;
    node.frame_idx = static_cast<int>(input_.frames.size());
    node.time_ns = time_ns;
    input_.frames.push_back(node);
    shard_.frames.push_back({node.frame_idx, shard_from_node, TrackingState::kTracked, true});
  }

  void Add(std::int64_t time_ns,
           const Rigid3& target_from_source,
           const Matrix6d& covariance,
           bool is_bridge) {
    const int source = shard_.frames.back().frame_idx;
    AddNode(time_ns, shard_.frames.back().shard_from_camera * target_from_source.Inverse());
    shard_.edges.push_back({source, source + 1, target_from_source, covariance, is_bridge});
  }

  std::size_t file_idx_;
  PoseGraphInput& input_;
  OdometryShard shard_;
};

}  // namespace

void AdoptOdometry(PoseGraphInput* input) {
  for (std::size_t i = 0; i < input->edges.size(); ++i) {
    const std::vector<SensorEdge> odometry = TakeOdometry(&input->edges[i]);
    if (odometry.empty()) continue;
    Adopter(i, input).Adopt(odometry);
    return;
  }
  throw InputError({{"edges"}},
                   InputError::Remedy::kInText,
                   "no sensor measured motion; give the lists of frames with the odometry of a "
                   "camera, or the edges of a sensor's odometry");
}

}  // namespace nightmap
