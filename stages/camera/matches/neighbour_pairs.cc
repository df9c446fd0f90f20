// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/matches/neighbour_pairs.h"

#include <algorithm>
#include <set>
#include <utility>

namespace nightmap {

NeighbourPairs::NeighbourPairs(const FeaturesShard& features, int first_frame_idx)
    : features_(features), first_frame_idx_(first_frame_idx) {
  for (const FrameFeatures& frame : features.frames) {
    if (frame.IsDescribed()) described_.push_back(frame.frame_idx);
  }
}

std::vector<FramePair> NeighbourPairs::AtOffsets(const std::vector<int>& offsets) const {
  std::vector<FramePair> pairs;
  for (const FrameFeatures& frame : features_.frames) {
    if (frame.frame_idx < first_frame_idx_ || frame.IsDescribed()) continue;
    pairs.push_back(MakePair(frame.reference_frame_idx, frame.frame_idx));
  }
  for (int i = FirstOwn(); i < static_cast<int>(described_.size()); ++i) {
    for (const int offset : offsets) {
      if (i >= offset) pairs.push_back(MakePair(At(i - offset), At(i)));
    }
  }
  return pairs;
}

std::vector<FramePair> NeighbourPairs::Wide(const std::vector<FramePair>& tried, int reach) const {
  std::set<std::pair<int, int>> done;
  std::set<int> found;
  for (const FramePair& pair : tried) {
    done.insert({pair.frame_a, pair.frame_b});
    if (pair.status == PairStatus::kAccepted) found.insert(pair.frame_b);
  }
  std::vector<FramePair> pairs;
  for (int i = FirstOwn(); i < static_cast<int>(described_.size()); ++i) {
    if (found.contains(At(i))) continue;
    for (int k = std::max(0, i - reach); k < i; ++k) {
      if (!done.contains({At(k), At(i)})) pairs.push_back(MakePair(At(k), At(i)));
    }
  }
  return pairs;
}

int NeighbourPairs::FirstOwn() const {
  return static_cast<int>(std::ranges::lower_bound(described_, first_frame_idx_) -
                          described_.begin());
}

}  // namespace nightmap
