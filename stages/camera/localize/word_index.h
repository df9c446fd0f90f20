// SPDX-License-Identifier: Apache-2.0
// The map's descriptors by visual word. The descriptors of a word lie next to each other in memory,
// because scanning the words of a large map would otherwise miss the cache.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/camera/vocabulary_tree.h"
#include "pipeline/io/landmarks_io.h"

namespace nightmap {

// Const after construction. Assumes that the words of a descriptor are its path down the tree, as
// the landmarks stage writes them.
class WordIndex {
 public:
  struct Block {
    std::span<const int> rows;             // indices of the map's descriptors
    const std::uint8_t* values = nullptr;  // these descriptors
    int Size() const { return static_cast<int>(rows.size()); }
  };

  WordIndex(const LandmarkMap& map, const VocabularyTree& tree);
  // Descriptors under a node of the vocabulary, at any level.
  Block Of(int word) const;

 private:
  struct Range {
    int begin = 0;
    int end = 0;
  };

  std::size_t descriptor_size_;
  std::vector<int> rows_;             // by tree path: descriptors under a node are adjacent
  std::vector<std::uint8_t> values_;  // by row, in the same order
  std::vector<Range> ranges_;         // by node
};

}  // namespace nightmap
