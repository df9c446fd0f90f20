// SPDX-License-Identifier: Apache-2.0
// Keyframes that see the same points, and how a step of the adjustment moves them.
#pragma once

#include <utility>
#include <vector>

#include "pipeline/geometry/index_groups.h"
#include "stages/ceiling/ceiling_adjust/ceiling_problem.h"

namespace nightmap {

struct CeilingStep {
  std::vector<Vector5d> keyframes;
  std::vector<Eigen::Vector3d> points;
  Vector5d mounting = Vector5d::Zero();
  Eigen::Vector2d wheels = Eigen::Vector2d::Zero();
  double level_m = 0;
  double expected_gain = 0;  // of the cost, were it quadratic
};

// By keyframe the others that share a point or a motion with it, ascending.
std::vector<std::vector<int>> FindNeighbours(const CeilingProblem& problem,
                                             const IndexGroups& sightings_of_point,
                                             std::size_t num_keyframes);

// Steps are applied to relative poses along a breadth-first tree of neighbours, and to the place
// of a point as its first keyframe sees it. A part that turns as a whole then keeps its shape,
// while poses that are moved one by one along the tangent tear it apart, so that a long way needs
// many short steps.
class KeyframeTree {
 public:
  // Neighbours connect all keyframes. Points that no keyframe sees stay.
  KeyframeTree(const std::vector<std::vector<int>>& neighbours,
               const CeilingProblem& problem,
               const IndexGroups& sightings_of_point,
               std::size_t num_points);

  CeilingUnknowns Moved(const CeilingUnknowns& unknowns,
                        const CeilingStep& step,
                        double length) const;  // multiplies the step

 private:
  std::vector<std::pair<std::size_t, std::size_t>> edges_;  // parent and child, parents first
  std::vector<std::size_t> first_keyframe_;                 // by point; -1: none
};

}  // namespace nightmap
