// SPDX-License-Identifier: Apache-2.0
// Errors of pictures and wheels over their standard deviations, with derivatives.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "pipeline/ceiling/planar_pose.h"
#include "stages/ceiling/ceiling_adjust/ceiling_problem.h"

namespace nightmap {

inline constexpr double kMinDepth_m = 0.05;
// Where a motion is so short that its own noise is none, samples and rounding remain.
inline constexpr double kMinMotionSigma_m = 5e-4;
inline constexpr double kMinMotionSigma_rad = 1e-3;
inline constexpr double kLevelSigma_m = 0.01;  // of a ceiling that is level

// A loss of a squared error s: Cost is half of it, Weight its derivative.
struct CauchyLoss {
  double scale = 1;

  double Cost(double s) const { return 0.5 * scale * scale * std::log1p(s / (scale * scale)); }
  double Weight(double s) const { return 1 / (1 + s / (scale * scale)); }
};

struct HuberLoss {
  double scale = 1;

  double Cost(double s) const {
    return s <= scale * scale ? 0.5 * s : scale * std::sqrt(s) - 0.5 * scale * scale;
  }
  double Weight(double s) const { return s <= scale * scale ? 1 : scale / std::sqrt(s); }
};

inline constexpr HuberLoss kWheelLoss{3};
inline constexpr CauchyLoss kLevelLoss{1};

struct LinearSighting {
  Eigen::Vector2d residual;
  Eigen::Matrix<double, 2, 5> by_keyframe, by_mounting;
  Eigen::Matrix<double, 2, 3> by_point;
};

// A keyframe's view of the ceiling.
class KeyframeView {
 public:
  KeyframeView(const CeilingProblem& problem, const Vector5d& keyframe, const Vector5d& mounting)
      : camera_(problem.camera),
        map_from_robot_(keyframe.head<3>()),
        mounted_at_(problem.robot_from_camera.translation +
                    Eigen::Vector3d(mounting[3], mounting[4], 0)) {
    const Eigen::Vector3d turn = -Eigen::Vector3d(keyframe[3], keyframe[4], 0) - mounting.head<3>();
    const double angle_rad = turn.norm();
    const Eigen::Vector3d axis = turn / std::max(angle_rad, 1e-12);
    camera_from_robot_ = Eigen::AngleAxisd(angle_rad, axis).toRotationMatrix() *
                         problem.robot_from_camera.rotation.conjugate().toRotationMatrix();
    const double sine = angle_rad > 1e-8 ? std::sin(angle_rad) / angle_rad : 1;
    const double cosine = angle_rad > 1e-8 ? (1 - std::cos(angle_rad)) / angle_rad : 0;
    by_turn_ = sine * Eigen::Matrix3d::Identity() + (1 - sine) * axis * axis.transpose() +
               cosine * Skew(axis);
  }

  // Nothing where the point is not in front of the camera.
  std::optional<Eigen::Vector2d> Error_px(const Eigen::Vector3d& point,
                                          const Eigen::Vector2d& pixel) const {
    const Eigen::Vector3d in_camera = InCamera(PointFrom(map_from_robot_, point).point);
    if (!(in_camera.z() >= kMinDepth_m)) return {};
    return Eigen::Vector2d(camera_.fx * in_camera.x() / in_camera.z() + camera_.cx - pixel.x(),
                           camera_.fy * in_camera.y() / in_camera.z() + camera_.cy - pixel.y());
  }

  // The point is in front of the camera.
  LinearSighting Linearize(const Eigen::Vector3d& point,
                           const Eigen::Vector2d& pixel,
                           double sigma_px) const {
    const SeenPoint seen = PointFrom(map_from_robot_, point);
    const Eigen::Vector3d in_camera = InCamera(seen.point);
    const double u = in_camera.x() / in_camera.z(), v = in_camera.y() / in_camera.z();
    Eigen::Matrix<double, 2, 3> by_camera;
    by_camera << camera_.fx, 0, -camera_.fx * u, 0, camera_.fy, -camera_.fy * v;
    by_camera /= in_camera.z() * sigma_px;
    const Eigen::Matrix<double, 2, 3> by_robot = by_camera * camera_from_robot_;
    // The turn's vector has the other sign of the tilt and the mounting.
    const Eigen::Matrix<double, 2, 3> by_tilt = by_camera * Skew(in_camera) * by_turn_;
    LinearSighting linear;
    linear.residual << camera_.fx * u + camera_.cx - pixel.x(),
        camera_.fy * v + camera_.cy - pixel.y();
    linear.residual /= sigma_px;
    linear.by_keyframe << by_robot * seen.by_pose, by_tilt.leftCols<2>();
    linear.by_mounting << by_tilt, -by_robot.leftCols<2>();
    linear.by_point = by_robot * seen.by_point;
    return linear;
  }

 private:
  Eigen::Vector3d InCamera(const Eigen::Vector3d& in_robot) const {
    return camera_from_robot_ * (in_robot - mounted_at_);
  }

  Camera camera_;
  Eigen::Vector3d map_from_robot_;
  Eigen::Vector3d mounted_at_;
  Eigen::Matrix3d camera_from_robot_;  // with the tilt and the mounting
  Eigen::Matrix3d by_turn_;            // left Jacobian of the turn's rotation vector
};

// Along and across the robot's heading, and of it.
inline Eigen::Vector3d SigmaOf(const CeilingNoise& noise, const KeyframeMotion& motion) {
  if (!motion.is_measured) {
    const double unknown_m = noise.unknown_speed_m_per_s * motion.time_s;
    return {unknown_m, unknown_m, noise.unknown_turn_rad_per_s * motion.time_s};
  }
  const double along_m = noise.distance_sigma_m * std::sqrt(motion.distance_m);
  const double turn_rad = std::hypot(noise.heading_sigma_rad * std::sqrt(motion.distance_m),
                                     noise.turn_sigma_rad * std::sqrt(motion.turn_rad));
  return {std::hypot(along_m, kMinMotionSigma_m),
          std::hypot(0.2 * along_m, kMinMotionSigma_m),
          std::hypot(turn_rad, kMinMotionSigma_rad)};
}

struct LinearMotion {
  Eigen::Vector3d residual;
  Eigen::Matrix3d by_before, by_after;  // x, y, heading of map_from_robot
  Eigen::Matrix<double, 3, 2> by_wheels;
};

// `before` and `after` are x, y, heading (not wrapped). Errors are of the motion that the wheels
// should have measured, so that a smaller map does not make their noise smaller.
inline LinearMotion LinearizeMotion(const CeilingNoise& noise,
                                    const KeyframeMotion& motion,
                                    const Eigen::Vector3d& before,
                                    const Eigen::Vector3d& after,
                                    const Eigen::Vector2d& wheels) {
  const double turned_rad = wheels[1] * motion.distance_m;
  const double scale = 1 / (1 + wheels[0]);
  const Eigen::Vector3d sizes(scale, scale, 1);
  const ComposedPose between = Between(before + Eigen::Vector3d(0, 0, 0.5 * turned_rad), after);
  const Eigen::Vector3d measured = ToVector(motion.before_from_after);
  LinearMotion linear;
  linear.residual = sizes.cwiseProduct(between.pose) - measured;
  linear.residual[2] = WrapAngle_rad(linear.residual[2] - 0.5 * turned_rad);
  linear.by_before = sizes.asDiagonal() * between.by_first;
  linear.by_after = sizes.asDiagonal() * between.by_second;
  linear.by_wheels.col(0) << -scale * scale * between.pose.head<2>(), 0;
  linear.by_wheels.col(1) = 0.5 * motion.distance_m * linear.by_before.col(2);
  linear.by_wheels(2, 1) = -motion.distance_m;
  const Eigen::Vector3d per_sigma = SigmaOf(noise, motion).cwiseInverse();
  linear.residual = per_sigma.asDiagonal() * linear.residual;
  linear.by_before = per_sigma.asDiagonal() * linear.by_before;
  linear.by_after = per_sigma.asDiagonal() * linear.by_after;
  linear.by_wheels = per_sigma.asDiagonal() * linear.by_wheels;
  return linear;
}

// The tilt in a keyframe is that of the mounting, but for vibrations.
struct ExpectedTilt {
  ExpectedTilt(const CeilingNoise& noise, const Vector5d& keyframe)
      : difference(keyframe.tail<2>()), information(Information(noise.vibration_sigma_rad)) {}

  static double Information(double sigma) { return 1 / std::max(sigma * sigma, 1e-18); }
  double Cost() const { return 0.5 * information * difference.squaredNorm(); }

  Eigen::Vector2d difference;
  double information;
};

// Unknowns that all keyframes share: mounting, wheels, level.
inline constexpr int kNumCommon = 8;

// Mounting and wheels are as they were told; the level is as high as somebody measured.
struct ExpectedCommon {
  using Vector = Eigen::Matrix<double, kNumCommon, 1>;

  ExpectedCommon(const CeilingNoise& noise,
                 const CeilingProblem& problem,
                 const CeilingUnknowns& unknowns) {
    constexpr double kMountingSigma_m = 0.03;
    const double tilt_rad = noise.mounting_tilt_sigma_rad;
    Vector sigma;
    sigma << tilt_rad, tilt_rad, tilt_rad, kMountingSigma_m, kMountingSigma_m, noise.scale_sigma,
        noise.heading_bias_sigma_rad_per_m, problem.level ? problem.level->sigma_m : 1;
    information = sigma.unaryExpr(&ExpectedTilt::Information);
    difference << unknowns.mounting, unknowns.wheels, 0;
    if (problem.level) {
      difference[7] = unknowns.level_m - problem.level->height_m;
    }
  }
  double Cost() const { return 0.5 * difference.dot(information.cwiseProduct(difference)); }

  Vector difference, information;
};

}  // namespace nightmap
