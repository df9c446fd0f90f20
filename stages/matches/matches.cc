// SPDX-License-Identifier: Apache-2.0
#include "stages/matches/matches.h"

#include <algorithm>
#include <iterator>

#include "pipeline/io/features_io.h"
#include "stages/matches/neighbour_pairs.h"

namespace nightmap {
namespace {

VerifyOptions MakeVerifyOptions(const MatchesOptions& options, DescriptorKind kind) {
  VerifyOptions verify;
  verify.kind = kind;
  verify.max_ratio = options.max_ratio;
  verify.min_spread = options.min_spread;
  verify.pose.max_error_px = options.max_error_px;
  verify.pose.max_depth_error = options.max_depth_error;
  verify.pose.min_inliers = options.min_inliers;
  verify.pose.max_iterations = options.max_ransac_iterations;
  return verify;
}

}  // namespace

void MatchesOptions::Register(OptionList& list) {
  list.Add("max_ratio", &max_ratio, Range(0.3, 1.0), "Lowe's ratio of nearest to second nearest");
  list.Add("pair_offsets",
           &pair_offsets,
           Range(1, 100),
           "each described frame is matched to the described frames at these offsets before it");
  list.Add("wide_search",
           &wide_search,
           Range(0, 1000),
           "a described frame without a match among these is matched to this many before it");
  list.Add("max_error_px", &max_error_px, Range(0.5, 20), "inlier threshold on reprojection");
  list.Add("max_depth_error",
           &max_depth_error,
           Range(0.005, 1),
           "inlier threshold on measured depth, relative");
  list.Add("min_inliers", &min_inliers, Range(4, 1000), "smallest number of inliers of a pair");
  list.Add("min_spread",
           &min_spread,
           Range(0, 1),
           "share of the image that a pair's inliers must cover");
  list.Add("max_ransac_iterations",
           &max_ransac_iterations,
           Range(10, 100000),
           "RANSAC iterations per pair");
  list.Add("seed", &seed, Range(0, 1e6), "seed of RANSAC");
}

std::vector<FramePair> RunMatches(const MatchesOptions& options,
                                  const FramesWithFeatures& input,
                                  int first_frame_idx,
                                  int num_threads,
                                  Progress& progress) {
  CheckFeaturesOfFrames(input.frames, input.features);
  const VerifyOptions verify = MakeVerifyOptions(options, input.features.kind);
  const NeighbourPairs neighbours(input.features, first_frame_idx);
  std::vector<FramePair> pairs = neighbours.AtOffsets(options.pair_offsets);
  VerifyPairs(verify, nullptr, input, options.seed, num_threads, progress, &pairs);
  std::vector<FramePair> wide = neighbours.Wide(pairs, options.wide_search);
  VerifyPairs(verify, nullptr, input, options.seed, num_threads, progress, &wide);
  std::ranges::move(wide, std::back_inserter(pairs));
  SortPairs(&pairs);
  return pairs;
}

}  // namespace nightmap
