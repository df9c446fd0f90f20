// SPDX-License-Identifier: Apache-2.0
// The residual of bundle adjustment, apart so that its derivatives can be tested.
#pragma once

#include <algorithm>
#include <optional>

#include "pipeline/geometry/bundle_adjustment.h"

namespace nightmap {

// Derivatives of a residual.
struct ObservationJacobian {
  Eigen::Matrix<double, 3, 6> by_pose;  // left perturbation of camera_from_world
  Eigen::Matrix3d by_point;
  Eigen::Matrix3d by_calibration;  // focal scale, readout, depth scale
};

// Residual (pixel x, pixel y, depth) of one observation over its standard deviations. The depth
// scale divides what is predicted: were the measurement multiplied, its deviation would have to
// follow, or small maps would cost less.
class ObservationError {
 public:
  static constexpr double kMinDepth_m = 0.05;  // nearer, or behind, a projection means nothing

  ObservationError(const BundleObservation& observation,
                   const Camera& camera,
                   const PointMotion& motion)
      : observation_(observation),
        camera_(camera),
        motion_(motion),
        row_fraction_(observation.pixel.y() / std::max(1, camera.height - 1) - 0.5),
        pixel_weight_(1 / observation.pixel_sigma_px),
        depth_weight_(observation.depth_m > 0 ? 1 / observation.noise.Sigma_m(observation.depth_m)
                                              : 0.0) {}

  // Nothing for a point that the camera cannot see. `jacobian` may be null.
  std::optional<Eigen::Vector3d> Evaluate(const Rigid3& camera_from_world,
                                          const Eigen::Vector3d& point_in_world,
                                          const CameraCalibration& calibration,
                                          ObservationJacobian* jacobian) const {
    const auto& [focal, readout_s, scale] = calibration;
    const Eigen::Vector3d in_middle = camera_from_world * point_in_world;
    const Eigen::Vector3d drift =  // over the whole readout of a second
        row_fraction_ * (motion_.angular_rad_per_s.cross(in_middle) + motion_.linear_m_per_s);
    const Eigen::Vector3d p = in_middle + readout_s * drift;
    if (!(p.z() >= kMinDepth_m)) return {};
    const Eigen::Vector2d from_centre(camera_.fx * p.x() / p.z(), camera_.fy * p.y() / p.z());
    const Eigen::Vector2d centre(camera_.cx, camera_.cy);
    Eigen::Vector3d residual;
    residual << pixel_weight_ * (focal * from_centre + centre - observation_.pixel),
        depth_weight_ * (p.z() / scale - observation_.depth_m);
    if (!jacobian) return residual;
    const Eigen::Matrix3d by_p = ByMovedPoint(p, focal, scale);
    const Eigen::Matrix3d by_middle =
        by_p + readout_s * row_fraction_ * by_p * Skew(motion_.angular_rad_per_s);
    jacobian->by_pose << -by_middle * Skew(in_middle), by_middle;
    jacobian->by_point = by_middle * camera_from_world.rotation.toRotationMatrix();
    jacobian->by_calibration.col(0) << pixel_weight_ * from_centre, 0;
    jacobian->by_calibration.col(1) = by_p * drift;
    jacobian->by_calibration.col(2) << 0, 0, -depth_weight_ * p.z() / (scale * scale);
    return residual;
  }

 private:
  Eigen::Matrix3d ByMovedPoint(const Eigen::Vector3d& p, double focal, double scale) const {
    const double fx = pixel_weight_ * focal * camera_.fx;
    const double fy = pixel_weight_ * focal * camera_.fy;
    Eigen::Matrix3d by_p;
    by_p << fx / p.z(), 0, -fx * p.x() / (p.z() * p.z()),  //
        0, fy / p.z(), -fy * p.y() / (p.z() * p.z()),      //
        0, 0, depth_weight_ / scale;
    return by_p;
  }

  const BundleObservation& observation_;
  const Camera& camera_;
  const PointMotion& motion_;
  double row_fraction_;  // -0.5 in the first row, 0.5 in the last
  double pixel_weight_;
  double depth_weight_;
};

}  // namespace nightmap
