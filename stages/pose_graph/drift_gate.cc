// SPDX-License-Identifier: Apache-2.0
#include "stages/pose_graph/drift_gate.h"

#include <Eigen/Cholesky>

namespace nightmap {

DriftGate::DriftGate(const std::vector<GraphEdge>& edges, const std::map<int, Rigid3>& poses)
    : poses_(poses) {
  covariances_[poses.begin()->first] = Matrix6d::Zero();
  for (const GraphEdge& edge : edges) {
    if (edge.is_loop) continue;
    const Matrix6d adjoint = Adjoint(poses.at(edge.edge.frame_b));
    covariances_[edge.edge.frame_b] =
        covariances_.at(edge.edge.frame_a) + adjoint * edge.edge.covariance * adjoint.transpose();
  }
}

double DriftGate::Distance(const PoseEdge& loop) const {
  const Rigid3 b_from_world = poses_.at(loop.frame_b).Inverse();
  const Matrix6d adjoint = Adjoint(b_from_world);
  const Matrix6d drift = covariances_.at(loop.frame_b) - covariances_.at(loop.frame_a);
  const Matrix6d covariance = adjoint * drift * adjoint.transpose() + loop.covariance;
  const Rigid3 difference = b_from_world * poses_.at(loop.frame_a) * loop.b_from_a.Inverse();
  const Eigen::AngleAxisd rotation(difference.rotation);
  Eigen::Matrix<double, 6, 1> error;
  error << rotation.angle() * rotation.axis(), difference.translation;
  return std::sqrt(error.dot(covariance.ldlt().solve(error)));
}

}  // namespace nightmap
