// SPDX-License-Identifier: Apache-2.0
// vocabulary.h5: the tree and the words of every mapping frame.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/camera/vocabulary_tree.h"

namespace nightmap {

struct Vocabulary {
  VocabularyTree tree;
  std::vector<std::vector<int>> words;  // leaf of each feature of every mapping frame, by frame_idx
};

// They throw DataError naming file and field.
void WriteVocabulary(const std::filesystem::path& path,
                     const Vocabulary& vocabulary,
                     const std::string& config);
Vocabulary ReadVocabulary(const std::filesystem::path& path);
// The tree alone.
VocabularyTree ReadVocabularyTree(const std::filesystem::path& path);

}  // namespace nightmap
