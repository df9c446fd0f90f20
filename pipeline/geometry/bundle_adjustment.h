// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment of RGB-D cameras and points: reprojection plus measured depth, each over its
// standard deviation, robust loss, Schur elimination of the points (Triggs et al., 2000; depth
// residual as in Mur-Artal and Tardos, T-RO 2017, with sigma growing with z squared).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/geometry/camera.h"
#include "pipeline/geometry/rigid3.h"

namespace nightmap {

struct BundleObservation {
  int pose_idx = 0;
  int point_idx = 0;
  Eigen::Vector2d pixel;  // undistorted
  double depth_m = 0;     // 0 = not measured
  DepthNoise noise;
};

struct BundleProblem {
  std::vector<Rigid3> camera_from_world;  // one a pose
  std::vector<Camera> cameras;            // one a pose; distortion is not applied
  std::vector<bool> is_fixed;             // one a pose; at least one, or the gauge is free
  std::vector<Eigen::Vector3d> points_in_world;
  std::vector<BundleObservation> observations;
  // True depth over measured, of each depth sensor, and which sensor each pose has; empty: the
  // first.
  std::vector<double> depth_scales = {1};
  std::vector<int> depth_scale_idx;
};

struct BundleOptions {
  double pixel_sigma_px = 1.0;
  double robust_scale = 2.0;  // Huber's constant, in standard deviations
  int max_iterations = 20;
  // All but the first: the size of the whole map would change with a common factor, and nothing
  // seen tells it.
  bool estimate_depth_scales = false;
};

struct BundleSummary {
  double initial_cost = 0;
  double final_cost = 0;
  int num_iterations = 0;
};

// Optimizes poses and points in place. Deterministic: one thread, fixed order. Points with a single
// observation are held only by their depth. Observations whose point starts behind the camera are
// removed. Throws DataError when the solver fails.
BundleSummary AdjustBundle(const BundleOptions& options, BundleProblem* problem);

}  // namespace nightmap
