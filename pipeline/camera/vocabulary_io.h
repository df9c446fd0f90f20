// SPDX-License-Identifier: Apache-2.0
// vocabulary.h5: the tree and the words of every mapping frame. Arrays:
//   tree/kind           int32[1]          0 RootSIFT, 1 ORB, 2 BRISK
//   tree/depth          int32[1]
//   tree/nodes          int32[n x 3]      first child (0: leaf), number of children, level
//   tree/centres        uint8[n x size]   descriptor at the centre of each node
//   frames/word_offsets int64[frames + 1] where each frame's words start
//   frames/words        int32             leaf (node index) of each feature, frame after frame
#pragma once

#include <filesystem>
#include <string>

#include "pipeline/camera/vocabulary_tree.h"

namespace nightmap {

struct Vocabulary {
  VocabularyTree tree;
  InvertedFile inverted_file;  // over all mapping frames, by frame_idx
};

// Both throw DataError naming file and field.
void WriteVocabulary(const std::filesystem::path& path,
                     const Vocabulary& vocabulary,
                     const std::string& config);
Vocabulary ReadVocabulary(const std::filesystem::path& path);

}  // namespace nightmap
