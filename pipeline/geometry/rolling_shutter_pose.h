// SPDX-License-Identifier: Apache-2.0
// Pose of a camera that moved while its rolling shutter read the picture, estimated together with
// one velocity for all rows (as Hedborg et al., CVPR 2012, linearized) and, where the lens is not
// calibrated, with its focal length. A pose without velocity would explain half of the picture's
// distortion by a false rotation; a pose with a wrong focal length is too near or too far.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "pipeline/geometry/absolute_pose.h"
#include "pipeline/geometry/reprojection.h"

namespace nightmap {

// Motion of static points in the camera's frame from the first row to the last.
struct ReadoutMotion {
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();

  PointMotion PerReadout() const {
    return {turn_rad, shift_m};
  }  // motion per readout instead of per second
};

struct MovingPoseOptions {
  double turn_sigma_rad = 0.005;  // standard deviation of the expected motion, as a prior
  double shift_sigma_m = 0.002;   // likewise
  double max_error_px = 4.0;      // of an inlier
  double pixel_sigma_px = 1.0;
  // Standard deviation of the logarithm of the focal length, as a prior under Cauchy's loss, since a
  // picture may have been cropped; 0: calibrated.
  double focal_sigma_ratio = 0;
};

struct MovingPose {
  AbsolutePose pose;  // at the middle row; its covariance includes those of motion and focal length
  ReadoutMotion motion;
  double focal_scale = 1;        // focal length over that of the camera
  double focal_sigma_ratio = 0;  // standard deviation of its logarithm
};

// Robust least squares over pose, motion and focal length, from a pose near the solution and the
// focal length of `camera` times `focal_scale`. Ignores measured depths. Returns nothing when fewer
// than min_inliers agree, or when they do not determine the pose. Deterministic.
[[nodiscard]] std::optional<MovingPose> RefineMovingPose(const Camera& camera,
                                                         const std::vector<PointMatch>& matches,
                                                         const Rigid3& camera_from_world,
                                                         int min_inliers,
                                                         const MovingPoseOptions& options,
                                                         double focal_scale = 1);

}  // namespace nightmap
