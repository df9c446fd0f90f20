// SPDX-License-Identifier: Apache-2.0
// A point as a camera sees it: where it is predicted, how far that is from what was measured, and
// the derivatives. Every estimation of poses and points is made of this one residual.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <limits>

#include "pipeline/geometry/camera.h"
#include "pipeline/geometry/rigid3.h"

namespace nightmap {

// How points that stand still move in a camera's frame, per second: p' = angular x p + linear.
struct PointMotion {
  Eigen::Vector3d angular_rad_per_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d linear_m_per_s = Eigen::Vector3d::Zero();

  Eigen::Vector3d Velocity_m_per_s(const Eigen::Vector3d& point_in_camera) const {
    return angular_rad_per_s.cross(point_in_camera) + linear_m_per_s;
  }
};

// What may differ from what a camera's configuration says.
struct CameraCalibration {
  double focal_scale = 1;  // true focal length over the configured one
  double readout_s = 0;  // between the first row of an image and the last; the pose is the middle's
  double depth_scale = 1;  // true depth over measured
};

// What a picture tells of a point, and how surely: one over the standard deviations.
struct PointMeasurement {
  Eigen::Vector2d pixel;  // undistorted
  double depth_m = 0;
  double per_pixel_sigma = 1;  // 1 / px
  double per_depth_sigma = 0;  // 1 / m; 0: the depth was not measured
};

// Of the row of a pixel: -0.5 in the first, 0.5 in the last.
inline double RowFraction(const Camera& camera, const Eigen::Vector2d& pixel) {
  return pixel.y() / std::max(1, camera.height - 1) - 0.5;
}

// Distance from a pixel to where a point in the camera's frame projects; infinite for a point that
// the camera cannot see.
inline double ReprojectionError_px(const Camera& camera,
                                   const Eigen::Vector3d& point_in_camera,
                                   const Eigen::Vector2d& pixel) {
  const auto projected = camera.ProjectUndistorted(point_in_camera);
  return projected ? (*projected - pixel).norm() : std::numeric_limits<double>::infinity();
}

// The residual is pixel x, pixel y and depth, each over its standard deviation. The depth scale
// divides what is predicted: were the measurement multiplied, its deviation would have to follow,
// or small maps would cost less.
class Reprojection {
 public:
  using Matrix36d = Eigen::Matrix<double, 3, 6>;
  static constexpr double kMinDepth_m = 0.05;  // nearer, or behind, a projection means nothing

  // A camera that stands still, as it is configured.
  Reprojection(const Camera& camera, const Eigen::Vector3d& in_camera)
      : camera_(camera), in_middle_(in_camera), p_(in_camera) {}

  // `in_middle`: the point in the camera's frame while the middle row is read; it is seen in the
  // row at `row_fraction`.
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

  // The rest is for visible points only.
  Eigen::Vector3d Residual(const PointMeasurement& measured) const {
    const Eigen::Vector2d centre(camera_.cx, camera_.cy);
    Eigen::Vector3d residual;
    residual << measured.per_pixel_sigma *
                    (calibration_.focal_scale * FromCentre() + centre - measured.pixel),
        measured.per_depth_sigma * (p_.z() / calibration_.depth_scale - measured.depth_m);
    return residual;
  }

  // By the point in the camera's frame while its row is read.
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
  // By `in_middle`. This and those below take `by_p` of ByMovedPoint.
  Eigen::Matrix3d ByMiddlePoint(const Eigen::Matrix3d& by_p) const {
    return by_p + calibration_.readout_s * row_fraction_ * by_p * Skew(turn_per_s_);
  }
  // By a left perturbation of camera_from_world, from ByMiddlePoint.
  Matrix36d ByPose(const Eigen::Matrix3d& by_middle) const {
    Matrix36d by_pose;
    by_pose << -by_middle * Skew(in_middle_), by_middle;
    return by_pose;
  }
  // By the motion (angular, linear) at a readout of one second.
  Matrix36d ByMotion(const Eigen::Matrix3d& by_p) const {
    Matrix36d by_motion;
    by_motion << -row_fraction_ * by_p * Skew(in_middle_), row_fraction_ * by_p;
    return by_motion;
  }
  // By focal scale, readout and depth scale.
  Eigen::Matrix3d ByCalibration(const PointMeasurement& measured,
                                const Eigen::Matrix3d& by_p) const {
    const double scale = calibration_.depth_scale;
    Eigen::Matrix3d by_calibration;
    by_calibration.col(0) << measured.per_pixel_sigma * FromCentre(), 0;
    by_calibration.col(1) = by_p * drift_per_s_;
    by_calibration.col(2) << 0, 0, -measured.per_depth_sigma * p_.z() / (scale * scale);
    return by_calibration;
  }

 private:
  // From the image's centre, at the configured focal length.
  Eigen::Vector2d FromCentre() const {
    return {camera_.fx * p_.x() / p_.z(), camera_.fy * p_.y() / p_.z()};
  }

  const Camera& camera_;
  CameraCalibration calibration_;
  double row_fraction_ = 0;
  Eigen::Vector3d turn_per_s_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d in_middle_;
  Eigen::Vector3d drift_per_s_ = Eigen::Vector3d::Zero();  // of readout
  Eigen::Vector3d p_;
};

}  // namespace nightmap
