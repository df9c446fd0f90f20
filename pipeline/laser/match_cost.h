// SPDX-License-Identifier: Apache-2.0
// The cost that RefinePose (match_scan.h) makes small, for Ceres.
#pragma once

#include <ceres/cubic_interpolation.h>

#include <Eigen/Geometry>
#include <vector>

#include "pipeline/laser/likelihood_field.h"
#include "pipeline/laser/match_scan.h"

namespace nightmap {

// Neighbouring points whose errors are one and the same (an edge of a chair, a shift of the clock).
// The field is wider than the noise of a scanner, so that as many points count as if they erred
// alone.
inline constexpr double kPointsPerError = 1;
inline constexpr double kHeldSigma_m = 1e-3;
inline constexpr double kSmooth = 1e-6;  // keeps the root below differentiable

// Residuals of all points, then of the prior. 1 - field is half the squared distance from a wall
// over its variance.
class MatchCost {
 public:
  MatchCost(const LikelihoodField& field,
            const std::vector<Eigen::Vector2d>& points,
            const PosePrior& prior,
            const Rigid2& start,
            const Constraints& constraints)
      : field_(field),
        interpolator_(field),
        points_(points),
        prior_(prior),
        start_(start),
        held_(constraints.held.value_or(Eigen::Vector2d::Zero())) {
    for (const Eigen::Vector2d& normal : constraints.normals_in_robot) {
      normals_.push_back(Eigen::Rotation2Dd(start.heading_rad) * normal);
    }
  }

  int NumResiduals() const { return static_cast<int>(points_.size()) + 4; }

  template <typename T>
  bool operator()(const T* const pose, T* residuals) const {
    const T cosine = cos(pose[2]), sine = sin(pose[2]);
    const Eigen::Vector2d origin_cells = field_.ToCells({0, 0});
    const double cells_per_m = 1 / field_.Resolution_m();
    for (std::size_t i = 0; i < points_.size(); ++i) {
      const Eigen::Vector2d& point = points_[i];
      T x_m = cosine * point.x() - sine * point.y() + pose[0];
      T y_m = sine * point.x() + cosine * point.y() + pose[1];
      if (!normals_.empty()) MoveAcrossWall(i, &x_m, &y_m);
      T value;
      interpolator_.Evaluate(
          y_m * cells_per_m + origin_cells.y(), x_m * cells_per_m + origin_cells.x(), &value);
      const T missing = value < 1.0 ? 1.0 - value : T(0);  // the interpolation overshoots
      *residuals++ = sqrt((2.0 * missing + kSmooth) / kPointsPerError);
    }
    const Rigid2& mean = prior_.field_from_robot;
    *residuals++ = (pose[0] - mean.translation.x()) / prior_.sigma_m;
    *residuals++ = (pose[1] - mean.translation.y()) / prior_.sigma_m;
    *residuals++ = (pose[2] - mean.heading_rad) / prior_.sigma_rad;
    const Eigen::Vector2d& start_m = start_.translation;
    *residuals++ =
        ((pose[0] - start_m.x()) * held_.x() + (pose[1] - start_m.y()) * held_.y()) / kHeldSigma_m;
    return true;
  }

 private:
  // A point of a wall keeps its place along that wall.
  template <typename T>
  void MoveAcrossWall(std::size_t i, T* x_m, T* y_m) const {
    const Eigen::Vector2d& normal = normals_[i];
    if (normal.isZero()) return;
    const Eigen::Vector2d start_m = start_ * points_[i];
    const T across_m = (*x_m - start_m.x()) * normal.x() + (*y_m - start_m.y()) * normal.y();
    *x_m = start_m.x() + across_m * normal.x();
    *y_m = start_m.y() + across_m * normal.y();
  }

  const LikelihoodField& field_;
  ceres::BiCubicInterpolator<LikelihoodField> interpolator_;
  const std::vector<Eigen::Vector2d>& points_;
  const PosePrior& prior_;
  Rigid2 start_;
  Eigen::Vector2d held_;
  std::vector<Eigen::Vector2d> normals_;  // in the field, at the start
};

}  // namespace nightmap
