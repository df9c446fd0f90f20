// SPDX-License-Identifier: Apache-2.0
// Which frames of a shard are matched to which before them.
#pragma once

#include <vector>

#include "pipeline/features/verify_pairs.h"

namespace nightmap {

class NeighbourPairs {
 public:
  // Frames before first_frame_idx are only partners.
  NeighbourPairs(const FeaturesShard& features, int first_frame_idx);

  // Each tracked frame with its reference, each described one with those so many described ones
  // before it.
  std::vector<FramePair> AtOffsets(const std::vector<int>& offsets) const;

  // Of the described frames none of whose pairs in `tried` is accepted: the pairs with the `reach`
  // described frames before them that were not tried.
  std::vector<FramePair> Wide(const std::vector<FramePair>& tried, int reach) const;

 private:
  int At(int i) const { return described_[static_cast<std::size_t>(i)]; }
  int FirstOwn() const;

  const FeaturesShard& features_;
  int first_frame_idx_;
  std::vector<int> described_;  // frame indices, ascending
};

}  // namespace nightmap
