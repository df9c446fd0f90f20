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
  double keyframe_distance_m = 0.15;
  double keyframe_angle_rad = 0.15;
  double keyframe_min_overlap = 0.5;
  double max_pair_error_m = 0.2;
  double max_pair_error_rad = 0.1;
  double pixel_sigma_px = 1.0;
  double max_error_px = 4.0;
  int max_iterations = 15;
  int max_tracks_per_frame = 300;
  double bridge_m_per_s = 1.0;
  double bridge_rad_per_s = 1.0;

  void Register(OptionList& list);
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
