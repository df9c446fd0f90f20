// SPDX-License-Identifier: Apache-2.0
// odometry: poses the frames of one shard from verified pairs by bundle adjustment.
#pragma once

#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/geometry/bundle_adjustment.h"
#include "pipeline/io/features_io.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/io/matches_io.h"
#include "pipeline/io/odometry_io.h"

namespace nightmap {

struct OdometryOptions {
  OPTION(double, keyframe_distance_m, 0.15, {0.01, 10},
         "distance from the last keyframe at which a new one starts");
  OPTION(double, keyframe_angle_rad, 0.15, {0.01, 3},
         "rotation from the last keyframe at which a new one starts");
  OPTION(double, max_pair_error_m, 0.2, {0.001, 100},
         "a pair whose translation differs more from the chained poses is rejected as a false "
         "match");
  OPTION(double, pixel_sigma_px, 1.0, {0.1, 10}, "standard deviation of a keypoint");
  OPTION(double, max_error_px, 4.0, {0.5, 50},
         "observations with a larger error after adjustment are dropped");
  OPTION(int, max_iterations, 15, {1, 200}, "iterations per bundle adjustment");
  REGISTER_OPTIONS();
};

struct OdometryInput {
  std::vector<FrameRecord> frames;  // of the shard before (if any) and of the own shard
  std::vector<RgbdCamera> cameras;
  FeaturesShard features;        // of these frames, in their order
  std::vector<FramePair> pairs;  // of the own shard, sorted by (b, a)
  int first_frame_idx = 0;       // first frame of the own shard
};

struct OdometryResult {
  OdometryShard shard;
  std::vector<BundleSummary> adjustments;  // in order
  // Tracked frames that keep their chained pose, because too few points fit another.
  int num_unrefined = 0;
};

// 1. Poses each frame from the verified pair with most inliers to an earlier posed frame. A frame
//    without such a pair is bridged (interpolated between its neighbours, or moved on at constant
//    velocity) and reported; if later frames depend on it, it starts a new part.
// 2. Joins the inliers of all pairs that agree with the chain to tracks. Refines described frames
//    and points together, then each tracked frame against the points.
// 3. Chooses keyframes among the described frames by motion and overlap. Edges between
//    consecutive ones get the covariance of their relative pose given the adjusted points.
// Deterministic; one thread. Throws DataError when the input is inconsistent or an adjustment
// fails.
OdometryResult RunOdometry(const OdometryOptions& options,
                           const OdometryInput& input,
                           Progress& progress);

}  // namespace nightmap
