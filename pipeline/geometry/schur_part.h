// SPDX-License-Identifier: Apache-2.0
// A part of the points of a bundle adjustment with all that sees them: linearized, and the points
// eliminated. Parts bound the memory of large problems: linearized observations are most of it.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "pipeline/geometry/bundle_adjustment.h"
#include "pipeline/geometry/index_groups.h"

namespace nightmap {

struct ObservationJacobian {
  Eigen::Matrix<double, 3, 6> by_pose;  // left perturbation of camera_from_world
  Eigen::Matrix3d by_point;
  Eigen::Matrix3d by_calibration;  // focal scale, readout, depth scale or offset
};

// An observation linearized at the current estimate, times the square root of its robust weight.
struct LinearObservation {
  ObservationJacobian jacobian;
  Eigen::Vector3d residual;
};

// Linearizes an observation of the problem. Threads call it at once.
using Linearize = std::function<LinearObservation(std::size_t observation)>;

// Observations [begin, end) and the points [first_point, end_point), which no others see.
struct SchurRange {
  std::size_t begin = 0, end = 0;
  std::size_t first_point = 0, end_point = 0;
};

// Ranges of about `max_observations`, in order; one where observations are not in the order of
// their points.
std::vector<SchurRange> CutIntoRanges(const BundleProblem& problem, std::size_t max_observations);

// A variable's own curvature over `trust`.
template <typename Vector>
Vector SchurDamping(const Vector& hessian_diagonal, double trust) {
  constexpr double kMinCurvature = 1e-6;  // keeps the system regular where nothing is measured
  return hessian_diagonal.cwiseMax(kMinCurvature) / trust;
}

class SchurPart {
 public:
  using Matrix63d = Eigen::Matrix<double, 6, 3>;

  // A point at the current estimate.
  struct Point {
    Eigen::Matrix3d inverse = Eigen::Matrix3d::Zero();  // of the damped Hessian
    Eigen::Vector3d damping = Eigen::Vector3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    Eigen::Matrix3Xd by_calibration;  // three columns per sensor; none: held fixed
  };

  SchurPart(const BundleProblem& problem, const IndexGroups& of_point, bool has_calibrations)
      : problem_(problem), of_point_(of_point), has_calibrations_(has_calibrations) {}

  void LinearizeRange(const SchurRange& range, const Linearize& linearize, int num_threads);
  // Takes the range that was linearized last.
  void EliminatePoints(double trust, int num_threads);

  // All indices are those of the problem.
  const LinearObservation& Linear(int observation) const {
    return linear_[static_cast<std::size_t>(observation) - range_.begin];
  }
  const Matrix63d& PoseByPoint(int observation) const {
    return pose_by_point_[static_cast<std::size_t>(observation) - range_.begin];
  }
  const Point& At(std::size_t point) const { return points_[point - range_.first_point]; }

 private:
  void Eliminate(double trust, std::size_t point);

  const BundleProblem& problem_;
  const IndexGroups& of_point_;
  bool has_calibrations_;
  SchurRange range_;
  std::vector<LinearObservation> linear_;
  std::vector<Matrix63d> pose_by_point_;
  std::vector<Point> points_;
};

}  // namespace nightmap
