// SPDX-License-Identifier: Apache-2.0
// The error of a measured edge of a pose graph, and its derivatives.
#pragma once

#include <Eigen/Cholesky>

#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/odometry_io.h"

namespace nightmap {

// Difference of the predicted and the measured b_from_a as a left perturbation, over its standard
// deviation: residual = U (twice the vector of the quaternion, translation) with U^T U the
// information.
class EdgeError {
 public:
  explicit EdgeError(const PoseEdge& edge)
      : a_from_b_(edge.b_from_a.Inverse()),
        sqrt_information_(
            edge.covariance.llt().solve(Matrix6d::Identity()).eval().llt().matrixU()) {}

  Vector6d Residual(const Rigid3& world_from_a, const Rigid3& world_from_b) const {
    return sqrt_information_ * Vector(Difference(world_from_b.Inverse() * world_from_a));
  }

  struct Linear {
    Vector6d residual;
    Matrix6d by_a, by_b;  // derivatives by perturbations of the poses in the frames of a and b
  };

  Linear Linearize(const Rigid3& world_from_a, const Rigid3& world_from_b) const {
    const Rigid3 b_from_a = world_from_b.Inverse() * world_from_a;
    const Rigid3 difference = Difference(b_from_a);
    const double sign = difference.rotation.w() < 0 ? -1 : 1;
    Matrix6d by_perturbation = Matrix6d::Zero();
    by_perturbation.topLeftCorner<3, 3>() =
        sign *
        (difference.rotation.w() * Eigen::Matrix3d::Identity() - Skew(difference.rotation.vec()));
    by_perturbation.bottomLeftCorner<3, 3>() = -Skew(difference.translation);
    by_perturbation.bottomRightCorner<3, 3>().setIdentity();
    Linear linear;
    linear.residual = sqrt_information_ * Vector(difference);
    linear.by_b = -sqrt_information_ * by_perturbation;
    linear.by_a = -linear.by_b * Adjoint(b_from_a);
    return linear;
  }

 private:
  Rigid3 Difference(const Rigid3& b_from_a) const { return b_from_a * a_from_b_; }

  static Vector6d Vector(const Rigid3& difference) {
    const double factor = difference.rotation.w() < 0 ? -2 : 2;
    Vector6d vector;
    vector << factor * difference.rotation.vec(), difference.translation;
    return vector;
  }

  Rigid3 a_from_b_;
  Matrix6d sqrt_information_;
};

}  // namespace nightmap
