// SPDX-License-Identifier: Apache-2.0
// Where a scan fits best to a likelihood field: first every pose of a window (correlative scan
// matching: Olson, Real-time correlative scan matching, ICRA 2009), then refined to a fraction of a
// cell on the field's smooth interpolation.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/geometry/rigid2.h"
#include "pipeline/planar/likelihood_field.h"

namespace nightmap {

// A prior says what is known of a pose before the scan is looked at.
struct PosePrior {
  Rigid2 field_from_robot;
  double sigma_m = 0.1;
  double sigma_rad = 0.1;
};

struct ScanMatch {
  Rigid2 field_from_robot;
  // Mean of the field at the points, 0 .. 1.
  double score = 0;
  // Of x, y (metres) in the field's frame and of the heading (rad): the inverse curvature of the
  // score and the prior. A corridor leaves the prior's along its axis.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

// Mean of the field at the nearest cells to the points, 0 .. 1. Without points 0.
double ScoreOf(const LikelihoodField& field,
               const std::vector<Eigen::Vector2d>& points_in_robot,
               const Rigid2& field_from_robot);

// The best of all poses within three sigmas of the prior: cell by cell, and headings so dense that
// the farthest point moves by two cells. Best is the largest score less `kPriorWeight` times the
// squared Mahalanobis distance from the prior. Bounds over blocks of cells leave most poses out
// (branch and bound: Hess, Kohler, Rapp, Andor, Real-time loop closure in 2D LIDAR SLAM, ICRA
// 2016), and the best is exact. Deterministic.
inline constexpr double kPriorWeight = 0.01;
Rigid2 SearchPose(const LikelihoodField& field,
                  const std::vector<Eigen::Vector2d>& points_in_robot,
                  const PosePrior& prior);

// The most likely pose near `start`: 1 - field counts as half the squared distance of a point from
// a wall, over the field's variance, and the prior counts. Deterministic; one thread.
ScanMatch RefinePose(const LikelihoodField& field,
                     const std::vector<Eigen::Vector2d>& points_in_robot,
                     const PosePrior& prior,
                     const Rigid2& start);

// Both.
ScanMatch MatchScan(const LikelihoodField& field,
                    const std::vector<Eigen::Vector2d>& points_in_robot,
                    const PosePrior& prior);

}  // namespace nightmap
