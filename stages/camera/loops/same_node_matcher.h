// SPDX-License-Identifier: Apache-2.0
// Cheap putative matches of two frames. Compares only features that share a node of the vocabulary
// tree (direct index: Galvez-Lopez and Tardos, Bags of binary words for fast place recognition in
// image sequences, T-RO 2012).
#pragma once

#include <utility>
#include <vector>

#include "pipeline/camera/vocabulary_io.h"
#include "pipeline/io/features_io.h"

namespace nightmap {

class SameNodeMatcher {
 public:
  // `level` of the tree below the root: 1 compares the most features, the depth of the tree the
  // fewest. The features must be those of the vocabulary's frames and outlive the matcher.
  SameNodeMatcher(const Vocabulary& vocabulary, const FeaturesShard& features, int level);

  // Mutual nearest neighbours of two frames among the features that share a node. They must pass
  // Lowe's ratio test; a feature without a second candidate passes. Frames are indices into the
  // features. Sorted by a.
  std::vector<FeatureMatch> Match(int frame_a, int frame_b, double max_ratio) const;

 private:
  using Entry = std::pair<int, int>;  // node, feature

  const FeaturesShard& features_;
  std::vector<std::vector<Entry>> entries_;  // by frame, ascending
};

}  // namespace nightmap
