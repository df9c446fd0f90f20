// SPDX-License-Identifier: Apache-2.0
// Points, cameras and poses for OpenCV, and back.
#pragma once

#include <opencv2/core.hpp>

#include "pipeline/geometry/camera.h"
#include "pipeline/geometry/rigid3.h"

namespace nightmap {

inline cv::Point3f ToPoint(const Eigen::Vector3d& point) {
  const Eigen::Vector3f single = point.cast<float>();
  return {single.x(), single.y(), single.z()};
}
inline cv::Point2f ToPoint(const Eigen::Vector2d& pixel) {
  const Eigen::Vector2f single = pixel.cast<float>();
  return {single.x(), single.y()};
}

// Without distortion.
inline cv::Mat CameraMatrix(const Camera& camera) {
  return (cv::Mat_<double>(3, 3) << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
}

// From a rotation vector and a translation, double.
inline Rigid3 ToPose(const cv::Mat& rotation, const cv::Mat& translation) {
  const Eigen::Map<const Eigen::Vector3d> axis(rotation.ptr<double>());
  Vector6d step;
  step << axis, Eigen::Map<const Eigen::Vector3d>(translation.ptr<double>());
  return PerturbLeft(step, Rigid3{});
}

}  // namespace nightmap
