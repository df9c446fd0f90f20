// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment of RGB-D cameras and points: reprojection plus measured depth, each over its
// standard deviation, robust loss, Schur elimination of the points (Triggs et al., 2000; depth
// residual as in Mur-Artal and Tardos, T-RO 2017, with sigma growing with z squared). The cameras
// can be calibrated in it: focal length, and the time a rolling shutter takes to read an image (one
// velocity a frame, as Hedborg et al., CVPR 2012, linearized).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "pipeline/geometry/depth_noise.h"
#include "pipeline/geometry/reprojection.h"

namespace nightmap {

struct BundleObservation {
  int pose_idx = 0;
  int point_idx = 0;
  Eigen::Vector2d pixel;  // undistorted
  double depth_m = 0;     // 0 = not measured
  DepthNoise noise;
  double pixel_sigma_px = 1.0;
};

struct BundleProblem {
  std::vector<Rigid3> camera_from_world;  // one a pose
  std::vector<Camera> cameras;            // one a pose; distortion is not applied
  std::vector<bool> is_fixed;             // one a pose; at least one, or the gauge is free
  std::vector<Eigen::Vector3d> points_in_world;
  std::vector<BundleObservation> observations;
  std::vector<PointMotion> motions;  // one a pose; empty: the camera stands still
  // Which sensor each pose has; empty: the first.
  std::vector<int> sensor_idx;
  std::vector<CameraCalibration> calibrations = {{}};  // one a sensor
};

enum class RobustLoss { kHuber, kCauchy };  // the second all but forgets outliers

struct BundleOptions {
  RobustLoss loss = RobustLoss::kHuber;
  double robust_scale = 2.0;  // the loss's constant, in standard deviations
  int max_iterations = 20;
  // All but the first: the size of the whole map would change with a common factor, and nothing
  // seen tells it.
  bool estimate_depth_scales = false;
  // Focal lengths and readout, from these deviations, which hold what the motion does not tell.
  bool calibrate = false;
  double focal_scale_sigma = 0.01;
  double readout_sigma_s = 0.02;
  int num_threads = 1;  // changes no result
};

enum class BundleEnd {
  kNothingSeen,    // no observation is left, nothing was adjusted
  kConverged,      // another step would gain next to nothing
  kMaxIterations,  // the last steps still gained
  kStalled,        // the last steps gained nothing, though they should have
};

const char* BundleEndText(BundleEnd end);

struct BundleSummary {
  double initial_cost = 0;  // half the robust sum of squares over the variances
  double final_cost = 0;
  int num_iterations = 0;  // steps tried
  int num_accepted = 0;    // of these, steps that lowered the cost
  BundleEnd end = BundleEnd::kNothingSeen;
};

// Optimizes poses and points in place, by Levenberg-Marquardt. Deterministic. Points with a single
// observation are held only by their depth. Observations whose point starts behind the camera are
// removed. Throws DataError when sizes do not fit, when a number is none, when the system does not
// fit into memory, and when no step lowers the cost though it should: nothing is adjusted then.
[[nodiscard]] BundleSummary AdjustBundle(const BundleOptions& options, BundleProblem* problem);

// Distance of an observation from where its point is predicted; infinite for a point that the
// camera cannot see.
double ReprojectionError_px(const BundleProblem& problem, const BundleObservation& observation);

}  // namespace nightmap
