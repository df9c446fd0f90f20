// SPDX-License-Identifier: Apache-2.0
// Prediction of a point in a camera, its distance from the measurement, and the derivatives. All
// estimators of poses and points use this one residual.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <limits>

#include "pipeline/geometry/camera.h"
#include "pipeline/geometry/rigid3.h"

namespace nightmap {

// Motion of static points in a camera's frame, per second: p' = angular x p + linear.
struct PointMotion {
  Eigen::Vector3d angular_rad_per_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d linear_m_per_s = Eigen::Vector3d::Zero();

  Eigen::Vector3d Velocity_m_per_s(const Eigen::Vector3d& point_in_camera) const {
    return angular_rad_per_s.cross(point_in_camera) + linear_m_per_s;
  }
};

// Corrections to a camera's configuration.
struct CameraCalibration {
  double focal_scale = 1;  // true focal length over the configured one
  // Time from the first row of an image to the last; the pose is the middle row's.
  double readout_s = 0;
  double depth_scale = 1;     // true depth over measured
  double depth_offset_m = 0;  // measured depth less true, beside the scale
};

// Parts of the depth's calibration that an adjustment moves.
enum class DepthCalibration { kHeld, kScale, kOffset };

// A measurement of a point in a picture, with its inverse standard deviations.
struct PointMeasurement {
  Eigen::Vector2d pixel;  // undistorted
  double depth_m = 0;
  double per_pixel_sigma = 1;  // 1 / px
  double per_depth_sigma = 0;  // 1 / m; 0: the depth was not measured
};

// Relative row of a pixel: -0.5 in the first, 0.5 in the last.
inline double RowFraction(const Camera& camera, const Eigen::Vector2d& pixel) {
  return pixel.y() / std::max(1, camera.height - 1) - 0.5;
}

// Distance from a pixel to the projection of a point in the camera's frame; infinite for a point
// that the camera cannot see.
inline double ReprojectionError_px(const Camera& camera,
                                   const Eigen::Vector3d& point_in_camera,
                                   const Eigen::Vector2d& pixel) {
  const auto projected = camera.ProjectUndistorted(point_in_camera);
  return projected ? (*projected - pixel).norm() : std::numeric_limits<double>::infinity();
}

// The residual is pixel x, pixel y and depth, each over its standard deviation. The depth scale
// divides the prediction. If it multiplied the measurement, the deviation would have to scale too,
// or small maps would cost less.
class Reprojection {
 public:
  using Matrix36d = Eigen::Matrix<double, 3, 6>;
  // A projection from nearer, or from behind, means nothing.
  static constexpr double kMinDepth_m = 0.05;

  // A camera that stands still, as configured.
  Reprojection(const Camera& camera, const Eigen::Vector3d& in_camera)
      : camera_(camera), in_middle_(in_camera), p_(in_camera) {}

  // `in_middle` is the point in the camera's frame while the middle row is read; the point is seen
  // in the row at `row_fraction`.
  Reprojection(const Camera& camera,
               const Eigen::Vector3d& in_middle,
               double row_fraction,
               const PointMotion& motion,
               const CameraCalibration& calibration)
      : camera_(camera),
        calibration_(calibration),
        row_fraction_(row_fraction),
        turn_per_s_(motion.angular_rad_per_s),
        in_middle_(in_middle),
        drift_per_s_(row_fraction * motion.Velocity_m_per_s(in_middle)),
        p_(in_middle + calibration.readout_s * drift_per_s_) {}

  bool IsVisible() const { return p_.z() >= kMinDepth_m; }

  // All functions below are for visible points only.
  Eigen::Vector3d Residual(const PointMeasurement& measured) const {
    const Eigen::Vector2d centre(camera_.cx, camera_.cy);
    Eigen::Vector3d residual;
    residual << measured.per_pixel_sigma *
                    (calibration_.focal_scale * FromCentre() + centre - measured.pixel),
        measured.per_depth_sigma *
            (p_.z() / calibration_.depth_scale + calibration_.depth_offset_m - measured.depth_m);
    return residual;
  }

  // Derivative by the point in the camera's frame while its row is read.
  Eigen::Matrix3d ByMovedPoint(const PointMeasurement& measured) const {
    const double fx = measured.per_pixel_sigma * calibration_.focal_scale * camera_.fx;
    const double fy = measured.per_pixel_sigma * calibration_.focal_scale * camera_.fy;
    const double z = p_.z();
    Eigen::Matrix3d by_p;
    by_p << fx / z, 0, -fx * p_.x() / (z * z),  //
        0, fy / z, -fy * p_.y() / (z * z),      //
        0, 0, measured.per_depth_sigma / calibration_.depth_scale;
    return by_p;
  }
  // Derivative by `in_middle`. This and the functions below take `by_p` from ByMovedPoint.
  Eigen::Matrix3d ByMiddlePoint(const Eigen::Matrix3d& by_p) const {
    return by_p + calibration_.readout_s * row_fraction_ * by_p * Skew(turn_per_s_);
  }
  // Derivative by a left perturbation of camera_from_world, from ByMiddlePoint.
  Matrix36d ByPose(const Eigen::Matrix3d& by_middle) const {
    Matrix36d by_pose;
    by_pose << -by_middle * Skew(in_middle_), by_middle;
    return by_pose;
  }
  // Derivative by the motion (angular, linear) at a readout of one second.
  Matrix36d ByMotion(const Eigen::Matrix3d& by_p) const {
    Matrix36d by_motion;
    by_motion << -row_fraction_ * by_p * Skew(in_middle_), row_fraction_ * by_p;
    return by_motion;
  }
  // Derivative by focal scale, readout and what of the depth's calibration moves.
  Eigen::Matrix3d ByCalibration(const PointMeasurement& measured,
                                const Eigen::Matrix3d& by_p,
                                DepthCalibration moved) const {
    Eigen::Matrix3d by_calibration;
    by_calibration.col(0) << measured.per_pixel_sigma * FromCentre(), 0;
    by_calibration.col(1) = by_p * drift_per_s_;
    by_calibration.col(2) << 0, 0, measured.per_depth_sigma * ByDepth(moved);
    return by_calibration;
  }

 private:
  // Derivative of the predicted measurement of depth.
  double ByDepth(DepthCalibration moved) const {
    if (moved == DepthCalibration::kHeld) return 0;
    if (moved == DepthCalibration::kOffset) return 1;
    return -p_.z() / (calibration_.depth_scale * calibration_.depth_scale);
  }
  // Pixel offset from the image's centre, at the configured focal length.
  Eigen::Vector2d FromCentre() const {
    return {camera_.fx * p_.x() / p_.z(), camera_.fy * p_.y() / p_.z()};
  }

  const Camera& camera_;
  CameraCalibration calibration_;
  double row_fraction_ = 0;
  Eigen::Vector3d turn_per_s_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d in_middle_;
  Eigen::Vector3d drift_per_s_ = Eigen::Vector3d::Zero();  // per second of readout
  Eigen::Vector3d p_;
};

}  // namespace nightmap
