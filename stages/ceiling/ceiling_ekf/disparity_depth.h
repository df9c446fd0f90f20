// SPDX-License-Identifier: Apache-2.0
// The depth of a corner as CN103680291A takes it from two pictures: Z = f T / (x1 - x2).
#pragma once

#include <Eigen/Core>
#include <optional>

#include "stages/ceiling/ceiling_ekf/upward_camera.h"

namespace nightmap {

struct DisparityDepth {
  double depth_m = 0;  // z in the second view
  struct ByView {
    Eigen::RowVector3d pose;
    Eigen::RowVector2d tilt, pixel;
  };
  ByView by_first, by_second;
};

// T is the way of the camera between the views, and x1 - x2 how far the corner moved against it,
// after the robot's turn is taken out. The camera is taken for level but for its mounting, as in
// the publication; derivatives by the tilt are those at none. None without such a disparity: where
// the camera stood still, or the corner moved along with it or across.
std::optional<DisparityDepth> DepthByDisparity(const UpwardCamera& camera,
                                               const Eigen::Vector3d& first_pose,
                                               const Eigen::Vector2d& first_pixel,
                                               const Eigen::Vector3d& second_pose,
                                               const Eigen::Vector2d& second_pixel);

}  // namespace nightmap
