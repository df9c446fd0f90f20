// SPDX-License-Identifier: Apache-2.0
// Pose of a camera that moved while its rolling shutter read the picture, estimated together with
// one velocity for all rows (as Hedborg et al., CVPR 2012, linearized) and, where the lens is not
// calibrated, with its focal length and principal point. A pose without velocity would explain half
// of the picture's distortion by a false rotation; one with a wrong focal length is too near or
// far.
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
  // Standard deviation of the logarithm of the focal length, as a prior under Cauchy's loss, since
  // a picture may have been cropped; 0: calibrated.
  double focal_sigma_ratio = 0;
  // Standard deviation of an uncalibrated camera's principal point on each axis, over the picture's
  // longer side.
  double centre_sigma_ratio = 0.02;
};

struct MovingPose {
  AbsolutePose pose;  // at the middle row; its covariance includes those of motion and lens
  ReadoutMotion motion;
  Camera camera;                 // with the lens that was found
  double focal_sigma_ratio = 0;  // standard deviation of the logarithm of its focal length
};

// Robust least squares over pose, motion and, where it is not calibrated, the lens (focal length
// and principal point). Starts from a pose near the solution and the lens `start`, which is
// `camera` for a calibrated one; the priors are about `camera`. Ignores measured depths. Returns
// nothing when fewer than min_inliers agree, or when they do not determine the pose. Deterministic.
[[nodiscard]] std::optional<MovingPose> RefineMovingPose(const Camera& camera,
                                                         const std::vector<PointMatch>& matches,
                                                         const Rigid3& camera_from_world,
                                                         int min_inliers,
                                                         const MovingPoseOptions& options,
                                                         const Camera& start);
// Likewise from the lens of `camera`.
[[nodiscard]] inline std::optional<MovingPose> RefineMovingPose(
    const Camera& camera,
    const std::vector<PointMatch>& matches,
    const Rigid3& camera_from_world,
    int min_inliers,
    const MovingPoseOptions& options) {
  return RefineMovingPose(camera, matches, camera_from_world, min_inliers, options, camera);
}

}  // namespace nightmap
