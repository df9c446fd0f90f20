// SPDX-License-Identifier: Apache-2.0
// Bundle adjustment of RGB-D cameras and points: residuals of reprojection and measured depth, each
// over its standard deviation, robust loss, Schur elimination of the points (Triggs et al., 2000;
// depth residual as in Mur-Artal and Tardos, T-RO 2017, with sigma growing with z squared). It can
// also calibrate the cameras: focal length, and the readout time of a rolling shutter (one velocity
// per frame, as Hedborg et al., CVPR 2012, linearized).
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
  std::vector<Rigid3> camera_from_world;  // one per pose
  std::vector<Camera> cameras;            // one per pose; distortion is not applied
  std::vector<bool> is_fixed;  // one per pose; at least one is true, or the gauge is free
  std::vector<Eigen::Vector3d> points_in_world;
  std::vector<BundleObservation> observations;
  std::vector<PointMotion> motions;  // one per pose; empty: the camera stands still
  // Sensor of each pose; empty: all have the first.
  std::vector<int> sensor_idx;
  std::vector<CameraCalibration> calibrations = {{}};  // one per sensor

  std::size_t SensorOf(const BundleObservation& observation) const {
    if (sensor_idx.empty()) return 0;
    return static_cast<std::size_t>(sensor_idx[static_cast<std::size_t>(observation.pose_idx)]);
  }
};

enum class RobustLoss { kHuber, kCauchy };  // Cauchy's loss nearly ignores outliers

struct BundleOptions {
  RobustLoss loss = RobustLoss::kHuber;
  double robust_scale = 2.0;  // the loss's constant, in standard deviations
  int max_iterations = 20;
  // Estimates all depth scales but the first: a common factor would scale the whole map, and no
  // observation determines it. Or all depth offsets, which parallax determines.
  DepthCalibration depth = DepthCalibration::kHeld;
  // Estimates focal lengths and readout. These prior deviations constrain what the motion leaves
  // open.
  bool calibrate = false;
  double focal_scale_sigma = 0.01;
  double readout_sigma_s = 0.02;
  int num_threads = 1;  // does not change the result
};

enum class BundleEnd {
  kNothingSeen,    // no observation is left; nothing was adjusted
  kConverged,      // another step would gain next to nothing
  kMaxIterations,  // the last steps still lowered the cost
  kStalled,        // the last steps did not lower the cost, though they should have
};

const char* BundleEndText(BundleEnd end);

struct BundleSummary {
  double initial_cost = 0;  // half the robust sum of squares over the variances
  double final_cost = 0;
  int num_iterations = 0;  // steps tried
  int num_accepted = 0;    // steps that lowered the cost
  BundleEnd end = BundleEnd::kNothingSeen;
};

// Optimizes poses and points in place, by Levenberg-Marquardt. Deterministic. Depth alone
// constrains a point with a single observation. Removes observations whose point starts behind the
// camera. Throws DataError when sizes do not fit, when a value is not a number, when the system
// does not fit into memory, and when no step lowers the cost though it should; it then adjusts
// nothing.
[[nodiscard]] BundleSummary AdjustBundle(const BundleOptions& options, BundleProblem* problem);

// Excess of the depth of every sensor at any distance, by a short adjustment of a copy that is free
// to move it; with standard deviations, which are large where the pictures have no parallax.
struct DepthOffsets {
  std::vector<double> offset_m;  // by sensor; empty: they could not be estimated
  std::vector<double> sigma_m;
};

// Starts from an adjusted problem. Deterministic. Throws DataError when sizes do not fit.
[[nodiscard]] DepthOffsets EstimateDepthOffsets(BundleOptions options, BundleProblem adjusted);

// Distance in pixels of an observation from the predicted projection of its point; infinite for a
// point that the camera cannot see.
double ReprojectionError_px(const BundleProblem& problem, const BundleObservation& observation);

}  // namespace nightmap
