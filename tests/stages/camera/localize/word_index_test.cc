// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/word_index.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "stages/camera/localize/landmark_index.h"
#include "tests/stages/camera/localize/scene_map.h"

namespace nightmap::word_index_test {

class WordIndexTest : public testing::Test {
 protected:
  int NumOfWord(int word, int level) const {
    int count = 0;
    for (int i = 0; i < map_.NumDescriptors(); ++i) count += map_.Word(i, level) == word;
    return count;
  }

  LandmarkScene scene_ = MakeLandmarkScene(3000, 2);
  VocabularyIndex vocabulary_ = IndexOf(MakeSceneVocabulary(scene_));
  LandmarkMap map_ = MakeSceneMap(scene_, vocabulary_.tree);
  LocalizeOptions options_;
};

TEST_F(WordIndexTest, AWordHasTheDescriptorsOfTheMapWithIt) {
  const WordIndex index(map_, vocabulary_.tree);
  int num_empty = 0;
  for (int word = 1; word < vocabulary_.tree.NumNodes(); ++word) {
    const int level = vocabulary_.tree.Nodes()[static_cast<std::size_t>(word)].level;
    const WordIndex::Block block = index.Of(word);
    EXPECT_EQ(block.Size(), NumOfWord(word, level));
    num_empty += block.Size() == 0;
    for (int i = 0; i < block.Size(); ++i) {
      const int row = block.rows[static_cast<std::size_t>(i)];
      EXPECT_EQ(map_.Word(row, level), word);
      EXPECT_TRUE(
          std::equal(block.values + 128 * i, block.values + 128 * (i + 1), map_.Descriptor(row)));
    }
  }
  EXPECT_LT(num_empty, vocabulary_.tree.NumNodes() / 2);
}

TEST_F(WordIndexTest, WordsWithoutDescriptorsAreEmpty) {
  std::fill(map_.words.begin(), map_.words.end(), vocabulary_.tree.NumNodes() - 1);
  const WordIndex index(map_, vocabulary_.tree);
  for (int word = 0; word + 1 < vocabulary_.tree.NumNodes(); ++word) {
    EXPECT_EQ(index.Of(word).Size(), 0);
  }
  EXPECT_EQ(index.Of(vocabulary_.tree.NumNodes() - 1).Size(), map_.NumDescriptors());
}

// Only as deep as needed, and never into a word without any landmark.
TEST_F(WordIndexTest, TooLargeAWordIsSearchedDeeper) {
  options_.search_level = 1;
  options_.max_word_descriptors = 40;
  const LandmarkIndex index(options_, map_, vocabulary_);
  int num_deeper = 0;
  for (int i = 0; i < map_.NumDescriptors(); ++i) {
    const int word = index.SearchWord(map_.Descriptor(i));
    const auto& node = vocabulary_.tree.Nodes()[static_cast<std::size_t>(word)];
    EXPECT_EQ(word, map_.Word(i, node.level));
    EXPECT_LE(index.OfWord(word).Size(), 40);
    if (node.level == 1) continue;
    ++num_deeper;
    EXPECT_GT(index.OfWord(map_.Word(i, node.level - 1)).Size(), 40);
  }
  EXPECT_GT(num_deeper, map_.NumDescriptors() / 2);
}

TEST_F(WordIndexTest, ADeeperWordWithoutLandmarksIsNotSearched) {
  options_.search_level = 1;
  options_.max_word_descriptors = 1;
  const std::vector<std::uint8_t> lone(map_.Descriptor(0), map_.Descriptor(1));
  const int level_1 = map_.Word(0, 1);
  // Every landmark of the first word now has another word below it than this one.
  const int leaf = map_.Word(0, 2);
  const auto depth = static_cast<std::size_t>(map_.num_word_levels);
  for (std::size_t i = 0; i < map_.words.size(); i += depth) {
    if (map_.words[i + 1] != leaf) continue;
    const int sibling =
        leaf == vocabulary_.tree.Nodes()[static_cast<std::size_t>(level_1)].first_child ? leaf + 1
                                                                                        : leaf - 1;
    for (std::size_t k = 1; k < depth; ++k) map_.words[i + k] = sibling;
  }
  const LandmarkIndex index(options_, map_, vocabulary_);
  EXPECT_EQ(index.SearchWord(lone.data()), level_1);
}

}  // namespace nightmap::word_index_test
