// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/matches/matches.h"

#include "tests/landmark_scene.h"
#include "tests/test_data.h"

namespace nightmap::matches_test {

TEST(RunMatches, TakesEveryOffsetAndIsTheSameAtAnyNumberOfThreads) {
  const LandmarkScene scene = MakeLandmarkScene();
  MatchesOptions options;
  options.pair_offsets = {1, 3};
  const auto pairs = RunMatches(options, scene.Input(), 2, NoProgress(), 1);
  const auto again = RunMatches(options, scene.Input(), 2, NoProgress(), 4);
  // b = 2 has one partner (1), b = 3..7 have two.
  ASSERT_EQ(pairs.size(), 11U);
  ASSERT_EQ(again.size(), pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    EXPECT_TRUE(pairs[i].frame_b - pairs[i].frame_a == 1 ||
                pairs[i].frame_b - pairs[i].frame_a == 3);
    EXPECT_EQ(pairs[i].b_from_a.Matrix(), again[i].b_from_a.Matrix());
    EXPECT_EQ(pairs[i].inliers.size(), again[i].inliers.size());
  }
}

TEST(RunMatches, ATrackedFrameIsPairedWithItsReferenceWithoutDescriptors) {
  LandmarkScene scene = MakeLandmarkScene();
  for (const int idx : {1, 2, 4}) TrackFrom(idx / 3 * 3, idx, &scene);
  MatchesOptions options;
  options.pair_offsets = {1, 2};
  std::vector<std::pair<int, int>> ends;
  for (const FramePair& pair : RunMatches(options, scene.Input(), 0, NoProgress(), 2)) {
    ends.emplace_back(pair.frame_a, pair.frame_b);
    EXPECT_EQ(pair.status, PairStatus::kAccepted);
    const auto error = LeftError(
        pair.b_from_a,
        TrueRelative(
            scene, static_cast<std::size_t>(pair.frame_a), static_cast<std::size_t>(pair.frame_b)));
    EXPECT_LT(error.norm(), 1e-4);
  }
  using Ends = std::vector<std::pair<int, int>>;  // 0, 3, 5, 6 and 7 are described
  EXPECT_EQ(ends,
            (Ends{{0, 1}, {0, 2}, {0, 3}, {3, 4}, {0, 5}, {3, 5}, {3, 6}, {5, 6}, {5, 7}, {6, 7}}));
}

// Frames 5 and 6 see nothing that is near them in the list.
TEST(RunMatches, AFrameThatMatchesNoNeighbourIsMatchedFartherBack) {
  LandmarkScene scene = MakeLandmarkScene();
  for (const std::size_t hidden : {3U, 4U}) scene.features.frames[hidden] = FrameFeatures{};
  scene.features.frames[3].frame_idx = 3;
  scene.features.frames[4].frame_idx = 4;
  MatchesOptions options;
  options.pair_offsets = {1, 2};
  options.wide_search = 3;
  const auto pairs = RunMatches(options, scene.Input(), 0, NoProgress(), 2);
  const auto status = [&](int a, int b) {
    const auto found = std::ranges::find_if(
        pairs, [&](const FramePair& pair) { return pair.frame_a == a && pair.frame_b == b; });
    return found == pairs.end() ? std::nullopt : std::optional(found->status);
  };
  EXPECT_EQ(status(2, 5), PairStatus::kAccepted);
  EXPECT_EQ(status(1, 5), std::nullopt);  // beyond the reach
  EXPECT_EQ(status(3, 6), std::nullopt);  // 6 matches 5: no need
  EXPECT_TRUE(std::ranges::is_sorted(
      pairs, {}, [](const FramePair& pair) { return std::pair(pair.frame_b, pair.frame_a); }));
}

TEST(RunMatches, RefusesFeaturesOfOtherFrames) {
  LandmarkScene scene = MakeLandmarkScene();
  scene.features.frames.pop_back();
  NIGHTMAP_EXPECT_ERROR(
      DataError, RunMatches({}, scene.Input(), 0, NoProgress(), 1), "not of the listed frames");
}

}  // namespace nightmap::matches_test
