// SPDX-License-Identifier: Apache-2.0
#include "stages/graph/pose_graph/drift_gate.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace nightmap {

DriftGate::DriftGate(const std::vector<PoseEdge>& tree) {
  std::map<int, std::vector<const PoseEdge*>> edges_of;
  for (const PoseEdge& edge : tree) {
    edges_of[edge.frame_a].push_back(&edge);
    edges_of[edge.frame_b].push_back(&edge);
  }
  for (const auto& [root, edges] : edges_of) {
    std::vector<int> reached;
    if (keyframes_.emplace(root, Keyframe()).second) reached.push_back(root);
    for (std::size_t i = 0; i < reached.size(); ++i) {
      const Keyframe from = keyframes_.at(reached[i]);
      for (const PoseEdge* edge : edges_of.at(reached[i])) {
        const bool is_forward = edge->frame_a == reached[i];
        const int other = is_forward ? edge->frame_b : edge->frame_a;
        if (other == from.parent) continue;
        Keyframe& to = keyframes_[other];
        to.parent = reached[i];
        to.depth = from.depth + 1;
        to.world_from_camera =
            from.world_from_camera * (is_forward ? edge->b_from_a.Inverse() : edge->b_from_a);
        const Matrix6d adjoint =
            Adjoint(is_forward ? to.world_from_camera : from.world_from_camera);
        to.covariance = from.covariance + adjoint * edge->covariance * adjoint.transpose();
        reached.push_back(other);
      }
    }
  }
}

// Covariance of the motion between the two, in the world.
Matrix6d DriftGate::Drift(int frame_a, int frame_b) const {
  const Keyframe* a = &keyframes_.at(frame_a);
  const Keyframe* b = &keyframes_.at(frame_b);
  const Matrix6d both = a->covariance + b->covariance;
  while (a != b) {
    const Keyframe*& deeper = a->depth > b->depth ? a : b;
    deeper = &keyframes_.at(deeper->parent);
  }
  return both - 2 * a->covariance;
}

double DriftGate::Distance(const PoseEdge& loop) const {
  const Rigid3 b_from_world = keyframes_.at(loop.frame_b).world_from_camera.Inverse();
  const Matrix6d adjoint = Adjoint(b_from_world);
  const Matrix6d covariance =
      adjoint * Drift(loop.frame_a, loop.frame_b) * adjoint.transpose() + loop.covariance;
  const Rigid3 difference =
      b_from_world * keyframes_.at(loop.frame_a).world_from_camera * loop.b_from_a.Inverse();
  const Eigen::AngleAxisd rotation(difference.rotation);
  Eigen::Matrix<double, 6, 1> error;
  error << rotation.angle() * rotation.axis(), difference.translation;
  return std::sqrt(error.dot(covariance.ldlt().solve(error)));
}

std::map<int, Rigid3> DriftGate::Poses() const {
  std::map<int, Rigid3> poses;
  for (const auto& [idx, keyframe] : keyframes_) poses.emplace(idx, keyframe.world_from_camera);
  return poses;
}

}  // namespace nightmap
