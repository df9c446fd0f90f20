// SPDX-License-Identifier: Apache-2.0
// How far the points of one scan are from the walls of another, and what that says of both poses.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "pipeline/geometry/rigid2.h"
#include "stages/laser/scan_adjust/wall_points.h"

namespace nightmap {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

// Part of the normal equations of Gauss-Newton, of x, y, heading of the scan, then of the target.
struct PairEquations {
  Matrix6 hessian = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();
  std::size_t num_matches = 0;
  double sum_squares_m2 = 0;  // of the distances from the walls
};

// A point matches the nearest point of the target when that is within gate_m and faces the same
// way; its residual is its distance from the wall there over sigma_m, with a Cauchy kernel. Poses
// are graph_from_robot. Pure.
PairEquations CompareScans(const std::vector<WallPoint>& scan,
                           const Rigid2& scan_pose,
                           const std::vector<WallPoint>& target,
                           const Rigid2& target_pose,
                           double gate_m,
                           double sigma_m);

}  // namespace nightmap
