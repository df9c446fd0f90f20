// SPDX-License-Identifier: Apache-2.0
// Relative pose of two frames from their features.
#pragma once

#include <limits>

#include "pipeline/base/options.h"
#include "pipeline/geometry/absolute_pose.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/io/matches_io.h"

namespace nightmap {

struct VerifyOptions {
  OPTION(double, max_ratio, 0.85, {0.3, 1.0}, "Lowe's ratio of nearest to second nearest");
  AbsolutePoseOptions pose;  // its seed is not used
  OPTION_AT("max_error_px", pose.max_error_px, {0.5, 20}, "inlier threshold on reprojection");
  OPTION_AT("min_inliers", pose.min_inliers, {4, 1000}, "smallest number of inliers of a pair");
  // Share of the image that a pair's inliers must cover: area of their covariance's ellipse over
  // the image's.
  double min_spread = 0.02;
  OPTION(int, max_motions, 5, {1, 20},
         "largest number of rigid motions searched in a pair; the one of the largest surface is "
         "what stands still");
  OPTION(int, seed, 0, {0, 1e6}, "seed of RANSAC; each pair draws from a random stream of its own");
  DescriptorKind kind = DescriptorKind::kRootSift;  // of the features
  // Limits b_from_a in its worst direction, where a stage sets it.
  double max_sigma_m = std::numeric_limits<double>::infinity();
  REGISTER_OPTIONS();
};

// Matches descriptors (ratio, mutual), or takes the tracker's matches if b was tracked from a. Then
// estimates the pose from the 3-D points of the frame that has more depth and the pixels of the
// other, against what stands still (static_motion.h). Fills all of `pair` except frame_a, frame_b
// and score.
void VerifyPair(const VerifyOptions& options,
                const FrameFeatures& a,
                const RgbdCamera& camera_a,
                const FrameFeatures& b,
                const RgbdCamera& camera_b,
                FramePair* pair);

// Likewise from given matches.
void VerifyMatches(const VerifyOptions& options,
                   const std::vector<FeatureMatch>& putative,
                   const FrameFeatures& a,
                   const RgbdCamera& camera_a,
                   const FrameFeatures& b,
                   const RgbdCamera& camera_b,
                   FramePair* pair);

// Share of the image that points cover: 4 pi sqrt(det(covariance)) over the area. Points spread
// evenly over the whole image give about 1; a small cluster or a line gives about 0.
double Spread(const std::vector<Eigen::Vector2d>& pixels, const Camera& camera);

}  // namespace nightmap
