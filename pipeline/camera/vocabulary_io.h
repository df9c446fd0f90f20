// SPDX-License-Identifier: Apache-2.0
// vocabulary.h5: the tree, the words of every mapping frame, and the inverted file over them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/camera/inverted_file.h"
#include "pipeline/camera/vocabulary_tree.h"

namespace nightmap {

struct Vocabulary {
  VocabularyTree tree;
  std::vector<std::vector<int>> words;  // leaf of each feature of every mapping frame, by frame_idx
};

// As a search for frames needs it.
struct VocabularyIndex {
  VocabularyTree tree;
  InvertedFile frames;  // every mapping frame
};

// They throw DataError naming file and field.
void WriteVocabulary(const std::filesystem::path& path,
                     const Vocabulary& vocabulary,
                     const std::string& config);
Vocabulary ReadVocabulary(const std::filesystem::path& path);
// The tree, and the inverted file with its postings left on disk: a query reads those of its words
// and throws ArtifactError where they cannot be read or make no sense. Other changes to their bytes
// go unnoticed.
VocabularyIndex OpenVocabulary(const std::filesystem::path& path);
// The tree alone.
VocabularyTree ReadVocabularyTree(const std::filesystem::path& path);

}  // namespace nightmap
