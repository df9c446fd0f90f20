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

// Const after construction: threads may share one.
class SameNodeMatcher {
 public:
  // `level` of the tree below the root: 1 compares the most features, the depth of the tree the
  // fewest. The vocabulary must outlive the matcher.
  SameNodeMatcher(const Vocabulary& vocabulary, int level);

  // Mutual nearest neighbours of two frames of the vocabulary among the features that share a node.
  // They must pass Lowe's ratio test; a feature without a second candidate passes. Sorted by a.
  // Throws InputError when a frame has more words than features.
  std::vector<FeatureMatch> Match(const FrameFeatures& a,
                                  const FrameFeatures& b,
                                  double max_ratio) const;

 private:
  using Entry = std::pair<int, int>;  // node, feature

  // Ascending.
  std::vector<Entry> EntriesOf(const FrameFeatures& frame) const;

  const Vocabulary& vocabulary_;
  std::vector<int> ancestors_;  // of each node at the level
};

}  // namespace nightmap
