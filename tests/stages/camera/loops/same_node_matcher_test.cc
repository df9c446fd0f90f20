// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/loops/same_node_matcher.h"

#include "tests/landmark_scene.h"
#include "tests/test_data.h"

namespace nightmap::same_node_matcher_test {

TEST(SameNodeMatcher, FindsTheCommonPointsAtEveryLevel) {
  const LandmarkScene scene = MakeLandmarkScene();
  const Vocabulary vocabulary = MakeSceneVocabulary(scene);
  // Equal descriptors have equal words: nothing can be missed, and nothing wrong is nearest.
  for (const int level : {1, 2, 5}) {
    const auto& frames = scene.features.frames;
    const auto matches = SameNodeMatcher(vocabulary, level).Match(frames[2], frames[4], 0.8);
    EXPECT_EQ(matches, CommonPoints(scene, 2, 4)) << level;
  }
}

TEST(SameNodeMatcher, HasNothingForATrackedFrame) {
  LandmarkScene scene = MakeLandmarkScene();
  TrackFrom(3, 4, &scene);
  const Vocabulary vocabulary = MakeSceneVocabulary(scene);
  const SameNodeMatcher matcher(vocabulary, 2);
  const auto& frames = scene.features.frames;
  EXPECT_TRUE(matcher.Match(frames[2], frames[4], 0.8).empty());
  EXPECT_TRUE(matcher.Match(frames[4], frames[2], 0.8).empty());
  EXPECT_FALSE(matcher.Match(frames[2], frames[3], 0.8).empty());
}

}  // namespace nightmap::same_node_matcher_test
