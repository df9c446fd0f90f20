// SPDX-License-Identifier: Apache-2.0
// Pose of a camera from 2-D to 3-D matches: RANSAC over P3P (Ke and Roumeliotis, CVPR 2017) or the
// 6-point DLT, with local optimization (Chum, Matas, Kittler, DAGM 2003; truncated score as in
// MSAC), then robust non-linear refinement. Also used for relative poses, with the other camera's
// frame as world.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "pipeline/geometry/camera.h"
#include "pipeline/geometry/depth_noise.h"
#include "pipeline/geometry/rigid3.h"

namespace nightmap {

// One match between a pixel and a point.
struct PointMatch {
  Eigen::Vector2d pixel;           // undistorted
  Eigen::Vector3d point_in_world;  // metres
  double depth_m = 0;              // measured z of the pixel in the camera; 0 = none
  double point_sigma_m = 0;        // standard deviation of the point along its ray; 0 = exact
};

// RANSAC samples of 3 matches, or of 6. The DLT needs no choice among four solutions. But at 30 %
// inliers it takes 37 times as many samples, and its points must not all lie on one plane.
enum class MinimalSolver { kP3p, kDlt6 };

struct AbsolutePoseOptions {
  MinimalSolver solver = MinimalSolver::kP3p;
  bool local_optimization = true;  // of each best sample so far
  bool refinement = true;          // of the final pose over its inliers
  double max_error_px = 3.0;       // inlier threshold on the reprojection error
  double max_depth_error = 0.1;    // inlier threshold on a measured depth, relative
  int min_inliers = 12;
  int min_iterations = 15;
  int max_iterations = 2000;
  double confidence = 0.9999;
  double pixel_sigma_px = 1.0;
  DepthNoise noise = {};
  std::uint64_t seed = 0;
};

struct AbsolutePose {
  Rigid3 camera_from_world;
  std::vector<int> inliers;  // indices of matches, ascending
  // Covariance of a left perturbation (rotation rad, translation m): inverse of the Hessian at the
  // solution.
  Matrix6d covariance;
  double rms_error_px = 0;  // reprojection error over the inliers
  int num_iterations = 0;
};

// `weights`: how much each match counts and how often it is drawn, positive; empty: all the same.
// Returns nothing when fewer than min_inliers agree. Deterministic in the seed. Does not apply the
// camera's distortion: pixels are undistorted.
[[nodiscard]] std::optional<AbsolutePose> EstimateAbsolutePose(
    const Camera& camera,
    const std::vector<PointMatch>& matches,
    const AbsolutePoseOptions& options,
    const std::vector<double>& weights = {});

// Runs only the robust refinement, from a pose near the solution, without sampling. Returns nothing
// when fewer than min_inliers agree with the refined pose.
[[nodiscard]] std::optional<AbsolutePose> RefineAbsolutePose(const Camera& camera,
                                                             const std::vector<PointMatch>& matches,
                                                             const Rigid3& camera_from_world,
                                                             const AbsolutePoseOptions& options);

// Covariance of a given pose; takes all matches as inliers. Returns nothing when they do not
// determine the pose.
[[nodiscard]] std::optional<Matrix6d> PoseCovariance(const Camera& camera,
                                                     const std::vector<PointMatch>& matches,
                                                     const Rigid3& camera_from_world,
                                                     const AbsolutePoseOptions& options);

}  // namespace nightmap
