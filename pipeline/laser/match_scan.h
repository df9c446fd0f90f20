// SPDX-License-Identifier: Apache-2.0
// Where a scan fits best to a likelihood field: first every pose around a prior (search_pose.h),
// then refined to a fraction of a cell on the field's smooth interpolation.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "pipeline/geometry/rigid2.h"
#include "pipeline/laser/field_pyramid.h"

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
  // Covariance of x, y (metres) in the field's frame and of the heading (rad): the inverse
  // curvature of the score and the prior. A corridor leaves the prior's along its axis.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
};

// Constraints say what is known of the points and the pose beside the field.
struct Constraints {
  // Each point has the normal of the wall that it lies on, in the robot's axes, or zero where it
  // lies on none; the list is empty where walls are not known. A point of a wall tells how far it
  // is from that wall, and nothing of its place along it, so that the end of what was seen does not
  // hold a scan.
  std::vector<Eigen::Vector2d> normals_in_robot;
  // Along this unit vector of the field's frame the pose keeps the place of the start.
  std::optional<Eigen::Vector2d> held;
};

// The covariance of a match with x and y along the axes of the robot, as that of an edge to it is.
Eigen::Matrix3d CovarianceInRobot(const ScanMatch& match);

// Mean of the field at the nearest cells to the points, 0 .. 1. Without points 0.
double ScoreOf(const LikelihoodField& field,
               const std::vector<Eigen::Vector2d>& points_in_robot,
               const Rigid2& field_from_robot);

// The most likely pose near `start`: 1 - field counts as half the squared distance of a point from
// a wall, over the field's variance, and the prior counts. Deterministic; one thread.
ScanMatch RefinePose(const LikelihoodField& field,
                     const std::vector<Eigen::Vector2d>& points_in_robot,
                     const PosePrior& prior,
                     const Rigid2& start,
                     const Constraints& constraints = {});

// Refines the best of all poses within three sigmas of the prior. Best is the largest score less
// `kPriorWeight` times the squared Mahalanobis distance from the prior.
inline constexpr double kPriorWeight = 0.01;
ScanMatch MatchScan(const FieldPyramid& pyramid,
                    const std::vector<Eigen::Vector2d>& points_in_robot,
                    const PosePrior& prior);

// The direction in the field's frame along which walls tell less of the position than
// kUnclearPoints points that face it would: the axis of a bare corridor. None where they tell
// enough.
inline constexpr double kUnclearPoints = 3;
std::optional<Eigen::Vector2d> UnclearDirection(
    const LikelihoodField& field,
    const std::vector<Eigen::Vector2d>& points_in_robot,
    const std::vector<Eigen::Vector2d>& normals_in_robot,
    const Rigid2& field_from_robot);

}  // namespace nightmap
