// SPDX-License-Identifier: Apache-2.0
// Tests whether a loop can be true, given how far the odometry may have drifted between its ends.
// In a building with repeated parts, false loops may agree with each other and outnumber the true
// ones; this test tells them apart before any optimization.
#pragma once

#include <map>
#include <vector>

#include "pipeline/io/odometry_io.h"

namespace nightmap {

// Covariances of the edges between two keyframes add up in the world frame, to first order (Barfoot
// and Furgale, Associating uncertainty with three-dimensional poses, T-RO 2014).
class DriftGate {
 public:
  // `tree` has edges without a cycle: one tree or several. Each tree's world is its lowest
  // keyframe.
  explicit DriftGate(const std::vector<PoseEdge>& tree);

  // Mahalanobis distance of the loop from the tree that both its ends are in, under the uncertainty
  // of both.
  double Distance(const PoseEdge& loop) const;

  // world_from_camera of every keyframe.
  std::map<int, Rigid3> Poses() const;

 private:
  struct Keyframe {
    int parent = -1;  // towards the root; a root has none
    int depth = 0;
    Rigid3 world_from_camera;
    // Relative to the root, a left perturbation in the world.
    Matrix6d covariance = Matrix6d::Zero();
  };

  Matrix6d Drift(int frame_a, int frame_b) const;

  std::map<int, Keyframe> keyframes_;
};

}  // namespace nightmap
