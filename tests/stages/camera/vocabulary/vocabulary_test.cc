// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/vocabulary/vocabulary.h"

#include "pipeline/camera/inverted_file.h"
#include "tests/landmark_scene.h"
#include "tests/test_data.h"

namespace nightmap::vocabulary_test {

class VocabularyTest : public testing::Test {
 protected:
  Vocabulary Run(int num_threads = 1) const {
    return RunVocabulary(options_, SiteFeatures(features_), NoProgress(), num_threads);
  }
  VocabularyOptions options_;
  FeaturesShard features_ = MakeLandmarkScene(800, 6).features;
};

TEST_F(VocabularyTest, IndexesEveryFeatureByItsLeaf) {
  const Vocabulary vocabulary = Run();
  ASSERT_EQ(vocabulary.words.size(), features_.frames.size());
  const InvertedFile inverted_file(vocabulary.words);
  for (std::size_t i = 0; i < features_.frames.size(); ++i) {
    const auto& words = vocabulary.words[i];
    EXPECT_EQ(words, vocabulary.tree.LeafWords(features_.frames[i].descriptors, 1));
    EXPECT_EQ(inverted_file.Query(words, 1).at(0).frame_idx, static_cast<int>(i));
  }
  EXPECT_GT(NumWords(vocabulary.tree), 50);
}

TEST_F(VocabularyTest, IsTheSameForOneAndTwoThreads) {
  const Vocabulary one = Run(1);
  const Vocabulary two = Run(2);
  EXPECT_EQ(one.tree.Centres(), two.tree.Centres());
  EXPECT_EQ(one.words, two.words);
}

TEST_F(VocabularyTest, TrainsOnASampleWhenThereIsTooMuch) {
  options_.max_training_descriptors = 120;
  EXPECT_LT(NumWords(Run().tree), 60);
}

TEST_F(VocabularyTest, RefusesMissingShards) {
  features_.frames.erase(features_.frames.begin());
  NIGHTMAP_EXPECT_ERROR(DataError, Run(), "frame_idx");
}

TEST_F(VocabularyTest, RefusesFramesWithoutAnyFeature) {
  features_.frames = {FrameFeatures{}};
  NIGHTMAP_EXPECT_ERROR(DataError, Run(), "no descriptors");
}

}  // namespace nightmap::vocabulary_test
