// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/matches/matches.h"

#include <algorithm>
#include <iterator>

#include "pipeline/io/features_io.h"
#include "stages/camera/matches/neighbour_pairs.h"

namespace nightmap {
std::vector<FramePair> RunMatches(const MatchesOptions& options,
                                  const FramesWithFeatures& input,
                                  int first_frame_idx,
                                  Progress& progress,
                                  int num_threads) {
  CheckFeaturesOfFrames(input.frames, input.features.Heads());
  const NeighbourPairs neighbours(input.features.Heads(), first_frame_idx);
  std::vector<FramePair> pairs = neighbours.AtOffsets(options.pair_offsets);
  VerifyPairs(options.verify, nullptr, input, num_threads, progress, &pairs);
  std::vector<FramePair> wide = neighbours.Wide(pairs, options.wide_search);
  VerifyPairs(options.verify, nullptr, input, num_threads, progress, &wide);
  std::ranges::move(wide, std::back_inserter(pairs));
  SortPairs(&pairs);
  return pairs;
}

}  // namespace nightmap
