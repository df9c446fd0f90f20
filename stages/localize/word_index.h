// SPDX-License-Identifier: Apache-2.0
// The descriptors of the map by visual word, those of a word one after the other in memory: going
// through a word of a large map costs little then.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "pipeline/features/vocabulary_tree.h"
#include "pipeline/io/landmarks_io.h"

namespace nightmap {

// Const after construction. Takes the words of a descriptor to be its path down the tree, as the
// landmarks stage writes them.
class WordIndex {
 public:
  struct Block {
    std::span<const int> rows;             // of the map's descriptors
    const std::uint8_t* values = nullptr;  // the same descriptors
    int Size() const { return static_cast<int>(rows.size()); }
  };

  WordIndex(const LandmarkMap& map, const VocabularyTree& tree);
  // Descriptors under a node of the vocabulary, of any level.
  Block Of(int word) const;

 private:
  struct Range {
    int begin = 0;
    int end = 0;
  };

  std::size_t descriptor_size_;
  std::vector<int> rows_;             // by path: those under a node follow each other
  std::vector<std::uint8_t> values_;  // row by row, in the same order
  std::vector<Range> ranges_;         // of each node
};

}  // namespace nightmap
