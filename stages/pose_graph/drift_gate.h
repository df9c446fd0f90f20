// SPDX-License-Identifier: Apache-2.0
// Whether a loop can be true, given how far the odometry may have drifted between its ends. A
// building with repeated parts offers loops that agree with each other and outnumber the true ones;
// this tells them apart before any optimization.
#pragma once

#include <map>
#include <vector>

#include "stages/pose_graph/optimize_graph.h"

namespace nightmap {

// Covariances of the chain's edges add up in the world frame to first order (Barfoot and Furgale,
// Associating uncertainty with three-dimensional poses, T-RO 2014).
class DriftGate {
 public:
  // `edges` join consecutive keyframes in order, loops among them are not looked at; poses are
  // world_from_camera by odometry.
  DriftGate(const std::vector<GraphEdge>& edges, const std::map<int, Rigid3>& poses);

  // Mahalanobis distance of the loop from the odometry, under the uncertainty of both.
  double Distance(const PoseEdge& loop) const;

 private:
  std::map<int, Rigid3> poses_;
  std::map<int, Matrix6d> covariances_;  // of each keyframe, a left perturbation in the world frame
};

}  // namespace nightmap
