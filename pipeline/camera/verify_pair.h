// SPDX-License-Identifier: Apache-2.0
// Relative pose of two frames from their features.
#pragma once

#include <limits>
#include <string>

#include "pipeline/base/options.h"
#include "pipeline/geometry/absolute_pose.h"
#include "pipeline/io/frames_io.h"
#include "pipeline/io/matches_io.h"

namespace nightmap {

struct VerifyOptions {
  DescriptorKind kind = DescriptorKind::kRootSift;  // of the features
  double max_ratio = 0.85;
  double min_spread = 0.02;  // area of the inliers' covariance ellipse over the image's area
  double max_sigma_m =
      std::numeric_limits<double>::infinity();  // of b_from_a, in the worst direction
  AbsolutePoseOptions pose;                     // its seed is not used
  int max_motions = 5;
  int seed = 0;  // each pair draws from a random stream of its own

  // Registers those that users set. `pair` names a pair in the help. max_sigma_m is not among them:
  // not every stage limits it.
  void Register(OptionList& list, const std::string& pair = "pair");
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
