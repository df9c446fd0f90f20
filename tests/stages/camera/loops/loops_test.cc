// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/loops/loops.h"

#include "tests/landmark_scene.h"
#include "tests/test_data.h"

namespace nightmap::loops_test {

TEST(RunLoops, FindsTheWayBackAndKeepsTheGap) {
  LandmarkScene scene = MakeLandmarkScene();
  const std::size_t num_out = scene.frames.size();
  GoAgain(&scene);
  LoopsOptions options;
  options.min_gap = 8;
  options.stride = 1;
  const Vocabulary vocabulary = MakeSceneVocabulary(scene);
  const auto loops = RunLoops(options, scene.Input(), vocabulary, NoProgress(), 2);
  int num_exact = 0;
  for (const FramePair& loop : loops) {
    EXPECT_GE(loop.frame_b - loop.frame_a, options.min_gap);
    num_exact += loop.frame_b - loop.frame_a == 8 && loop.status == PairStatus::kAccepted;
  }
  EXPECT_EQ(num_exact, 8);

  // Where only one frame finds a place, its neighbours do not confirm it.
  Vocabulary lonely = vocabulary;
  for (std::size_t i = num_out; i < lonely.words.size(); ++i) {
    if (i != num_out + 3) lonely.words[i].clear();
  }
  for (const FramePair& loop : RunLoops(options, scene.Input(), lonely, NoProgress(), 2)) {
    EXPECT_EQ(loop.frame_b, static_cast<int>(num_out) + 3);
    EXPECT_EQ(loop.status, PairStatus::kInconsistent);
  }

  options.min_gap = 16;
  EXPECT_TRUE(RunLoops(options, scene.Input(), vocabulary, NoProgress(), 2).empty());
}

TEST(RunLoops, RefusesAVocabularyOfOtherFeatures) {
  LandmarkScene scene = MakeLandmarkScene();
  GoAgain(&scene);
  const auto expect_refused = [](const LandmarkScene& listed, const Vocabulary& vocabulary) {
    LoopsOptions options;
    options.min_gap = 8;
    NIGHTMAP_EXPECT_ERROR(DataError,
                          RunLoops(options, listed.Input(), vocabulary, NoProgress(), 1),
                          "vocabulary: lists");
  };
  Vocabulary damaged = MakeSceneVocabulary(scene);
  for (auto& words : damaged.words) words.push_back(words[0]);  // of a feature too many
  expect_refused(scene, damaged);
  LandmarkScene later = scene;
  for (FrameRecord& frame : later.frames) frame.frame_idx += 5;
  for (FrameFeatures& frame : later.features.frames) frame.frame_idx += 5;
  expect_refused(later, MakeSceneVocabulary(scene));
}

}  // namespace nightmap::loops_test
