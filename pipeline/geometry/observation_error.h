// SPDX-License-Identifier: Apache-2.0
// The cost function of bundle adjustment, apart so that its derivatives can be tested.
#pragma once

#include <ceres/sized_cost_function.h>

#include <algorithm>

#include "pipeline/geometry/bundle_adjustment.h"

namespace nightmap {

// Residuals (pixel x, pixel y, depth) of one observation over their standard deviations.
// Parameters: rotation (x y z w) and translation of camera_from_world, point in the world,
// CameraCalibration (all blocks have three degrees of freedom, for which Ceres is fast). The depth
// scale divides what is predicted: were the measurement multiplied, its deviation would have to
// follow, or small maps would cost less.
class ObservationError : public ceres::SizedCostFunction<3, 4, 3, 3, 3> {
 public:
  static constexpr double kMinDepth_m = 0.05;  // nearer, or behind, a projection means nothing

  // `is_free`: 0 for the entries of CameraCalibration that must not move, else 1.
  ObservationError(const BundleObservation& observation,
                   const Camera& camera,
                   const PointMotion& motion,
                   const Eigen::Array3d& is_free = Eigen::Array3d::Ones())
      : observation_(observation),
        camera_(camera),
        motion_(motion),
        is_free_(is_free),
        row_fraction_(observation.pixel.y() / std::max(1, camera.height - 1) - 0.5),
        pixel_weight_(1 / observation.pixel_sigma_px),
        depth_weight_(observation.depth_m > 0 ? 1 / observation.noise.Sigma_m(observation.depth_m)
                                              : 0.0) {}

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override {
    const Eigen::Map<const Eigen::Quaterniond> rotation(parameters[0]);
    const Eigen::Map<const Eigen::Vector3d> translation(parameters[1]);
    const Eigen::Map<const Eigen::Vector3d> point(parameters[2]);
    const double focal = parameters[3][0];
    const double readout_s = parameters[3][1];
    const double scale = parameters[3][2];
    const Eigen::Vector3d in_middle = rotation * point + translation;
    const Eigen::Vector3d drift =  // over the whole readout of a second
        row_fraction_ * (motion_.angular_rad_per_s.cross(in_middle) + motion_.linear_m_per_s);
    const Eigen::Vector3d p = in_middle + readout_s * drift;
    if (p.z() < kMinDepth_m) return false;  // Ceres takes a shorter step
    const Eigen::Vector2d from_centre(camera_.fx * p.x() / p.z(), camera_.fy * p.y() / p.z());
    residuals[0] = pixel_weight_ * (focal * from_centre.x() + camera_.cx - observation_.pixel.x());
    residuals[1] = pixel_weight_ * (focal * from_centre.y() + camera_.cy - observation_.pixel.y());
    residuals[2] = depth_weight_ * (p.z() / scale - observation_.depth_m);
    if (!jacobians) return true;
    const Eigen::Matrix3d by_p = PointJacobian(p, focal, scale);
    FillPoseAndPoint(WithMotion(by_p, readout_s), rotation, point, jacobians);
    if (jacobians[3]) {
      Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> by_calibration(jacobians[3]);
      by_calibration.col(0) << is_free_[0] * pixel_weight_ * from_centre, 0;
      by_calibration.col(1) = is_free_[1] * by_p * drift;
      by_calibration.col(2) << 0, 0, -is_free_[2] * depth_weight_ * p.z() / (scale * scale);
    }
    return true;
  }

 private:
  Eigen::Matrix3d PointJacobian(const Eigen::Vector3d& p, double focal, double scale) const {
    const double fx = pixel_weight_ * focal * camera_.fx;
    const double fy = pixel_weight_ * focal * camera_.fy;
    Eigen::Matrix3d by_p;
    by_p << fx / p.z(), 0, -fx * p.x() / (p.z() * p.z()),  //
        0, fy / p.z(), -fy * p.y() / (p.z() * p.z()),      //
        0, 0, depth_weight_ / scale;
    return by_p;
  }

  // By the point where it is in the middle of the readout.
  Eigen::Matrix3d WithMotion(const Eigen::Matrix3d& by_p, double readout_s) const {
    return by_p + readout_s * row_fraction_ * by_p * Skew(motion_.angular_rad_per_s);
  }

  static void FillPoseAndPoint(const Eigen::Matrix3d& by_p,
                               const Eigen::Quaterniond& rotation,
                               const Eigen::Vector3d& point,
                               double** jacobians) {
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
  PointMotion motion_;
  Eigen::Array3d is_free_;
  double row_fraction_;  // -0.5 in the first row, 0.5 in the last
  double pixel_weight_;
  double depth_weight_;
};

}  // namespace nightmap
