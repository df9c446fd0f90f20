// SPDX-License-Identifier: Apache-2.0
// The cost function of bundle adjustment, apart so that its derivatives can be tested.
#pragma once

#include <ceres/sized_cost_function.h>

#include "pipeline/geometry/bundle_adjustment.h"

namespace nightmap {

// Residuals (pixel x, pixel y, depth) of one observation over their standard deviations.
// Parameters: rotation (x y z w) and translation of camera_from_world, point in the world, true
// depth over measured. The last divides what is predicted: were the measurement multiplied, its
// deviation would have to follow, or small maps would cost less.
class ObservationError : public ceres::SizedCostFunction<3, 4, 3, 3, 1> {
 public:
  static constexpr double kMinDepth_m = 0.05;  // nearer, or behind, a projection means nothing

  ObservationError(const BundleObservation& observation,
                   const Camera& camera,
                   double pixel_sigma_px)
      : observation_(observation),
        camera_(camera),
        pixel_weight_(1 / pixel_sigma_px),
        depth_weight_(observation.depth_m > 0 ? 1 / observation.noise.Sigma_m(observation.depth_m)
                                              : 0.0) {}

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override {
    const Eigen::Map<const Eigen::Quaterniond> rotation(parameters[0]);
    const Eigen::Map<const Eigen::Vector3d> translation(parameters[1]);
    const Eigen::Map<const Eigen::Vector3d> point(parameters[2]);
    const Eigen::Vector3d rotated = rotation * point;
    const Eigen::Vector3d p = rotated + translation;
    if (p.z() < kMinDepth_m) return false;  // Ceres takes a shorter step
    residuals[0] =
        pixel_weight_ * (camera_.fx * p.x() / p.z() + camera_.cx - observation_.pixel.x());
    residuals[1] =
        pixel_weight_ * (camera_.fy * p.y() / p.z() + camera_.cy - observation_.pixel.y());
    const double scale = parameters[3][0];
    residuals[2] = depth_weight_ * (p.z() / scale - observation_.depth_m);
    if (jacobians) FillJacobians(p, rotation, point, scale, jacobians);
    return true;
  }

 private:
  void FillJacobians(const Eigen::Vector3d& p,
                     const Eigen::Quaterniond& rotation,
                     const Eigen::Vector3d& point,
                     double scale,
                     double** jacobians) const {
    Eigen::Matrix3d by_p;
    by_p << camera_.fx / p.z(), 0, -camera_.fx * p.x() / (p.z() * p.z()),  //
        0, camera_.fy / p.z(), -camera_.fy * p.y() / (p.z() * p.z()),      //
        0, 0, 1 / scale;
    by_p.row(0) *= pixel_weight_;
    by_p.row(1) *= pixel_weight_;
    by_p.row(2) *= depth_weight_;
    if (jacobians[0]) {
      Eigen::Map<Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> by_rotation(jacobians[0]);
      by_rotation = by_p * RotationJacobian(rotation, point);
    }
    if (jacobians[1]) {
      Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> by_translation(jacobians[1]);
      by_translation = by_p;
    }
    if (jacobians[2]) {
      Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> by_point(jacobians[2]);
      by_point = by_p * rotation.toRotationMatrix();
    }
    if (jacobians[3]) {
      Eigen::Map<Eigen::Vector3d> by_scale(jacobians[3]);
      by_scale << 0, 0, -depth_weight_ * p.z() / (scale * scale);
    }
  }

  // Derivative of q * x by (qx, qy, qz, qw), from q * x = x + 2 w (v cross x) + 2 v cross (v cross
  // x), the form Eigen evaluates.
  static Eigen::Matrix<double, 3, 4> RotationJacobian(const Eigen::Quaterniond& q,
                                                      const Eigen::Vector3d& x) {
    const Eigen::Vector3d v = q.vec();
    const Eigen::Matrix3d outer = v * x.transpose();
    Eigen::Matrix<double, 3, 4> jacobian;
    jacobian.leftCols<3>() = 2 * (-q.w() * Skew(x) + v.dot(x) * Eigen::Matrix3d::Identity() +
                                  outer - 2 * x * v.transpose());
    jacobian.rightCols<1>() = 2 * v.cross(x);
    return jacobian;
  }

  BundleObservation observation_;
  Camera camera_;
  double pixel_weight_;
  double depth_weight_;
};

}  // namespace nightmap
