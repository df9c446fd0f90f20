// SPDX-License-Identifier: Apache-2.0
// Chooses which frames of a shard are matched to which earlier frames.
#pragma once

#include <vector>

#include "pipeline/camera/verify_pairs.h"

namespace nightmap {

class NeighbourPairs {
 public:
  // Frames before first_frame_idx serve only as partners.
  NeighbourPairs(const FeaturesShard& features, int first_frame_idx);

  // Pairs each tracked frame with its reference, and each described frame with the described frames
  // at the given offsets before it.
  std::vector<FramePair> AtOffsets(const std::vector<int>& offsets) const;

  // For described frames without an accepted pair in `tried`: the untried pairs with the `reach`
  // described frames before them.
  std::vector<FramePair> Wide(const std::vector<FramePair>& tried, int reach) const;

 private:
  int At(int i) const { return described_[static_cast<std::size_t>(i)]; }
  int FirstOwn() const;

  const FeaturesShard& features_;
  int first_frame_idx_;
  std::vector<int> described_;  // frame indices, ascending
};

}  // namespace nightmap
