// SPDX-License-Identifier: Apache-2.0
// matches/shard_NNNN.h5 and loops/loops.h5: geometrically verified pairs of frames.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/features_io.h"

namespace nightmap {

enum class PairStatus {
  kAccepted = 0,
  kTooFewMatches = 1,  // descriptors do not match, or matches have no depth
  kTooFewInliers = 2,  // no relative pose explains enough matches
  kPoorSpread = 3,     // the inliers cover too little of the image to determine a pose
  kInconsistent = 4,   // loops: the frames beside b do not match the place of a; not verified
  kUncertain = 5,      // loops: the inliers determine the pose too poorly
};

const char* PairStatusText(PairStatus status);

// Frames a < b. Pose and inliers are meaningful when accepted.
struct FramePair {
  int frame_a = 0;
  int frame_b = 0;
  PairStatus status = PairStatus::kTooFewMatches;
  int num_putative = 0;
  double score = 0;  // retrieval score of a loop candidate
  Rigid3 b_from_a;   // camera b from camera a
  // Covariance of a left perturbation (rotation rad, translation m) of b_from_a.
  Matrix6d covariance = Matrix6d::Identity();
  std::vector<FeatureMatch> inliers;
};

// A pair whose inliers stay in the file.
struct CountedPair : FramePair {
  int num_inliers = 0;
};

// All throw DataError naming file and field.
void WritePairs(const std::filesystem::path& path,
                const std::vector<FramePair>& pairs,
                const std::string& config);
std::vector<FramePair> ReadPairs(const std::filesystem::path& path);
// Does not read the inliers, which are most of the file.
std::vector<CountedPair> ReadCountedPairs(const std::filesystem::path& path);

}  // namespace nightmap
