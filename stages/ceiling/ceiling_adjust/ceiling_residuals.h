// SPDX-License-Identifier: Apache-2.0
// Residuals of ceiling_problem.h, over their standard deviations, as Ceres differentiates them.
#pragma once

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <cmath>
#include <numbers>

#include "stages/ceiling/ceiling_adjust/ceiling_problem.h"

namespace nightmap {

inline constexpr double kMinDepth_m = 0.05;
// Where a motion is so short that its own noise is none, samples and rounding remain.
inline constexpr double kMinMotionSigma_m = 5e-4;
inline constexpr double kMinMotionSigma_rad = 1e-3;
inline constexpr double kLevelSigma_m = 0.01;  // of a ceiling that is level

class SightingError {
 public:
  SightingError(const CeilingProblem& problem, const Eigen::Vector2d& pixel, double sigma_px)
      : camera_(problem.camera),
        camera_from_robot_(problem.robot_from_camera.rotation.conjugate().toRotationMatrix()),
        mounted_at_(problem.robot_from_camera.translation),
        pixel_(pixel),
        sigma_px_(sigma_px) {}

  template <typename T>
  bool operator()(const T* keyframe, const T* mounting, const T* point, T* residual) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const T cosine = ceres::cos(keyframe[2]), sine = ceres::sin(keyframe[2]);
    const T x = point[0] - keyframe[0], y = point[1] - keyframe[1];
    const Vector from_camera(cosine * x + sine * y - mounted_at_.x() - mounting[3],
                             cosine * y - sine * x - mounted_at_.y() - mounting[4],
                             point[2] - mounted_at_.z());
    const Vector as_mounted = camera_from_robot_.cast<T>() * from_camera;
    const T tilt[3] = {-keyframe[3] - mounting[0], -keyframe[4] - mounting[1], -mounting[2]};
    T in_camera[3];
    ceres::AngleAxisRotatePoint(tilt, as_mounted.data(), in_camera);
    if (in_camera[2] < kMinDepth_m) return false;
    residual[0] = (camera_.fx * in_camera[0] / in_camera[2] + camera_.cx - pixel_.x()) / sigma_px_;
    residual[1] = (camera_.fy * in_camera[1] / in_camera[2] + camera_.cy - pixel_.y()) / sigma_px_;
    return true;
  }

 private:
  Camera camera_;
  Eigen::Matrix3d camera_from_robot_;
  Eigen::Vector3d mounted_at_;
  Eigen::Vector2d pixel_;
  double sigma_px_;
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

class MotionError {
 public:
  MotionError(const CeilingNoise& noise, const KeyframeMotion& motion)
      : motion_(motion), sigma_(SigmaOf(noise, motion)) {}

  template <typename T>
  bool operator()(const T* before, const T* after, const T* wheels, T* residual) const {
    const T turned_rad = wheels[1] * motion_.distance_m;
    const T heading_rad = before[2] + 0.5 * turned_rad;
    const T cosine = ceres::cos(heading_rad), sine = ceres::sin(heading_rad);
    const T x = after[0] - before[0], y = after[1] - before[1];
    const Rigid2& measured = motion_.before_from_after;
    // The motion that the wheels should have measured, so that a smaller map does not make their
    // noise smaller.
    const T scale = 1.0 / (1.0 + wheels[0]);
    residual[0] = scale * (cosine * x + sine * y) - measured.translation.x();
    residual[1] = scale * (cosine * y - sine * x) - measured.translation.y();
    residual[2] = after[2] - before[2] - measured.heading_rad - turned_rad;
    const T turns = ceres::floor(residual[2] / (2 * std::numbers::pi) + 0.5);
    residual[2] -= turns * (2 * std::numbers::pi);
    for (int i = 0; i < 3; ++i) residual[i] /= sigma_[i];
    return true;
  }

 private:
  KeyframeMotion motion_;
  Eigen::Vector3d sigma_;
};

// Values that are near those expected: residual = (value - expected) / sigma.
template <int kSize, int kFirst, int kNum>
class ExpectedValues {
 public:
  using Values = Eigen::Matrix<double, kNum, 1>;
  ExpectedValues(const Values& expected, const Values& sigma)
      : expected_(expected), sigma_(sigma) {}

  static ceres::CostFunction* Cost(const Values& expected, const Values& sigma) {
    return new ceres::AutoDiffCostFunction<ExpectedValues, kNum, kSize>(
        new ExpectedValues(expected, sigma.cwiseMax(1e-9)));
  }

  template <typename T>
  bool operator()(const T* values, T* residual) const {
    for (int i = 0; i < kNum; ++i) residual[i] = (values[kFirst + i] - expected_[i]) / sigma_[i];
    return true;
  }

 private:
  Values expected_, sigma_;
};

class LevelError {
 public:
  template <typename T>
  bool operator()(const T* point, const T* level, T* residual) const {
    residual[0] = (point[2] - level[0]) / kLevelSigma_m;
    return true;
  }
};

}  // namespace nightmap
