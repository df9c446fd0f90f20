// SPDX-License-Identifier: Apache-2.0
// OpenCV's fisheye model, for camera.cc: the distorted radius is a polynomial in the angle to the
// axis, theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8). Points are on the plane
// z = 1, pictures before fx fy cx cy.
#pragma once

#include <optional>

#include "pipeline/geometry/camera.h"

namespace nightmap {

// 80 deg. Downstream of Undistort all is a pinhole, in which an error of a pixel grows by the
// square of 1 / cos: 33 times here, and without bound towards 90 deg.
inline constexpr double kMaxFisheyeAngle_rad = 1.3962634;

// Nothing beyond the largest angle, and where the polynomial has turned back.
std::optional<Eigen::Vector2d> DistortFisheye(const Camera& camera, const Eigen::Vector2d& point);

// The inverse; beyond the largest radius that has one, the point of that radius.
Eigen::Vector2d UndistortFisheye(const Camera& camera, const Eigen::Vector2d& distorted);

// The camera with the polynomial of which `scale` times the focal length has the same undistorted
// image (Camera::WithFocalScale), by least squares over the angles in the picture.
Camera RefitFisheye(const Camera& camera, double scale);

}  // namespace nightmap
