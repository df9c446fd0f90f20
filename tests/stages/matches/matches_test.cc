// SPDX-License-Identifier: Apache-2.0
#include "stages/matches/matches.h"

#include <Eigen/LU>

#include "pipeline/base/error.h"
#include "stages/matches/verify_pair.h"
#include "tests/landmark_scene.h"
#include "tests/test_data.h"

namespace nightmap {
namespace {

VerifyOptions TestVerifyOptions() {
  VerifyOptions options;
  options.pose.min_inliers = 15;
  return options;
}

FramePair Verify(const LandmarkScene& scene, const FrameFeatures& a, const FrameFeatures& b) {
  FramePair pair;
  VerifyPair(TestVerifyOptions(), a, scene.cameras[0], b, scene.cameras[0], &pair);
  return pair;
}

Rigid3 TrueRelative(const LandmarkScene& scene, std::size_t a, std::size_t b) {
  return scene.poses[b].pose.Inverse() * scene.poses[a].pose;
}

// Rotation (rad) and translation (m) of the left perturbation that takes `expected` to `actual`.
Eigen::Matrix<double, 6, 1> LeftError(const Rigid3& actual, const Rigid3& expected) {
  const Eigen::AngleAxisd rotation(actual.rotation * expected.rotation.conjugate());
  Eigen::Matrix<double, 6, 1> error;
  error.head<3>() = rotation.angle() * rotation.axis();
  error.tail<3>() = actual.translation - rotation.toRotationMatrix() * expected.translation;
  return error;
}

TEST(Spread, IsAboutOneOverTheImageAndZeroOnALine) {
  const Camera camera{640, 480, 500, 500, 320, 240};
  std::vector<Eigen::Vector2d> everywhere;
  std::vector<Eigen::Vector2d> line;
  for (int y = 0; y < 480; y += 10) {
    for (int x = 0; x < 640; x += 10) everywhere.emplace_back(x, y);
    line.emplace_back(y, y);
  }
  EXPECT_NEAR(Spread(everywhere, camera), 1.05, 0.1);
  EXPECT_NEAR(Spread(line, camera), 0, 1e-9);
  EXPECT_EQ(Spread({{1, 1}, {300, 20}}, camera), 0);
}

TEST(VerifyPair, FindsTheTruePoseWhicheverFrameHasDepth) {
  const LandmarkScene scene = MakeLandmarkScene();
  for (const int blind : {-1, 0, 1}) {
    FrameFeatures a = scene.features.frames[2];
    FrameFeatures b = scene.features.frames[4];
    if (blind == 0) a.depths_m.assign(a.depths_m.size(), 0);
    if (blind == 1) b.depths_m.assign(b.depths_m.size(), 0);
    const FramePair pair = Verify(scene, a, b);
    EXPECT_EQ(pair.status, PairStatus::kAccepted);
    EXPECT_LT(LeftError(pair.b_from_a, TrueRelative(scene, 2, 4)).norm(), 1e-4) << blind;
    for (const FeatureMatch& match : pair.inliers) {
      EXPECT_EQ(scene.frame_points[2][static_cast<std::size_t>(match.a)],
                scene.frame_points[4][static_cast<std::size_t>(match.b)]);
    }
  }
}

TEST(VerifyPair, RefusesFramesWithoutDepthOrWithoutCommonPoints) {
  const LandmarkScene scene = MakeLandmarkScene();
  FrameFeatures a = scene.features.frames[0];
  FrameFeatures b = scene.features.frames[1];
  a.depths_m.assign(a.depths_m.size(), 0);
  b.depths_m.assign(b.depths_m.size(), 0);
  EXPECT_EQ(Verify(scene, a, b).status, PairStatus::kTooFewMatches);
  EXPECT_EQ(Verify(scene, scene.features.frames[0], FrameFeatures()).status,
            PairStatus::kTooFewMatches);
}

// Same descriptors, positions shuffled: plenty of matches, no geometry.
TEST(VerifyPair, RefusesMatchesThatNoMotionExplains) {
  const LandmarkScene scene = MakeLandmarkScene();
  FrameFeatures b = scene.features.frames[1];
  Random random(3);
  for (auto& pixel : b.keypoints_px) {
    pixel = {static_cast<float>(random.Uniform(0, 639)),
             static_cast<float>(random.Uniform(0, 479))};
  }
  const FramePair pair = Verify(scene, scene.features.frames[0], b);
  EXPECT_GT(pair.num_putative, 100);
  EXPECT_EQ(pair.status, PairStatus::kTooFewInliers);
}

TEST(VerifyPair, RefusesInliersInOneCorner) {
  const LandmarkScene scene = MakeLandmarkScene(60000, 2);
  const FrameFeatures& all = scene.features.frames[1];
  FrameFeatures corner;
  for (int i = 0; i < all.NumFeatures() && corner.NumFeatures() < 60; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (all.keypoints_px[k].x() > 60 || all.keypoints_px[k].y() > 60) continue;
    corner.keypoints_px.push_back(all.keypoints_px[k]);
    corner.depths_m.push_back(all.depths_m[k]);
    corner.descriptors.insert(corner.descriptors.end(),
                              all.descriptors.begin() + 128L * i,
                              all.descriptors.begin() + 128L * (i + 1));
  }
  ASSERT_GT(corner.NumFeatures(), 30);
  EXPECT_EQ(Verify(scene, corner, corner).status, PairStatus::kPoorSpread);
}

// Normalized squared error of a pose with 6 degrees of freedom: 6 on average.
TEST(VerifyPair, CovarianceTellsTheError) {
  const LandmarkScene scene = MakeLandmarkScene();
  const DepthNoise& noise = scene.cameras[0].noise;
  double sum = 0;
  constexpr int kNumTrials = 40;
  for (int trial = 0; trial < kNumTrials; ++trial) {
    Random random(11, static_cast<std::uint64_t>(trial));
    FrameFeatures a = scene.features.frames[3];
    FrameFeatures b = scene.features.frames[4];
    for (FrameFeatures* frame : {&a, &b}) {
      for (float& depth_m : frame->depths_m) {
        depth_m += static_cast<float>(noise.Sigma_m(depth_m) * random.Gaussian());
      }
      for (auto& pixel : frame->keypoints_px) {
        pixel.x() += static_cast<float>(0.7 * random.Gaussian());
        pixel.y() += static_cast<float>(0.7 * random.Gaussian());
      }
    }
    const FramePair pair = Verify(scene, a, b);
    ASSERT_EQ(pair.status, PairStatus::kAccepted);
    const auto error = LeftError(pair.b_from_a, TrueRelative(scene, 3, 4));
    sum += error.dot(pair.covariance.inverse() * error);
  }
  EXPECT_GT(sum / kNumTrials, 2);
  EXPECT_LT(sum / kNumTrials, 15);
}

MatchesInput InputOf(const LandmarkScene& scene) {
  return {scene.frames, scene.cameras, scene.features};
}

TEST(MatchNeighbours, TakesEveryOffsetAndIsTheSameAtAnyNumberOfThreads) {
  const LandmarkScene scene = MakeLandmarkScene();
  MatchesOptions options;
  options.pair_offsets = {1, 3};
  Progress progress("test", false);
  const auto pairs = MatchNeighbours(options, InputOf(scene), 2, 1, progress);
  const auto again = MatchNeighbours(options, InputOf(scene), 2, 4, progress);
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

TEST(MatchNeighbours, ATrackedFrameIsPairedWithItsReferenceWithoutDescriptors) {
  LandmarkScene scene = MakeLandmarkScene();
  for (const int idx : {1, 2, 4}) TrackFrom(idx / 3 * 3, idx, &scene);
  MatchesOptions options;
  options.pair_offsets = {1, 2};
  Progress progress("test", false);
  std::vector<std::pair<int, int>> ends;
  for (const FramePair& pair : MatchNeighbours(options, InputOf(scene), 0, 2, progress)) {
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
TEST(MatchNeighbours, AFrameThatMatchesNoNeighbourIsMatchedFartherBack) {
  LandmarkScene scene = MakeLandmarkScene();
  for (const std::size_t hidden : {3U, 4U}) scene.features.frames[hidden] = FrameFeatures{};
  scene.features.frames[3].frame_idx = 3;
  scene.features.frames[4].frame_idx = 4;
  MatchesOptions options;
  options.pair_offsets = {1, 2};
  options.wide_search = 3;
  Progress progress("test", false);
  const auto pairs = MatchNeighbours(options, InputOf(scene), 0, 2, progress);
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

TEST(MatchNeighbours, RefusesFeaturesOfOtherFrames) {
  MatchesInput input = InputOf(MakeLandmarkScene());
  input.features.frames.pop_back();
  Progress progress("test", false);
  NIGHTMAP_EXPECT_ERROR(
      DataError, MatchNeighbours({}, input, 0, 1, progress), "not of the listed frames");
}

TEST(MatchLoops, FindsTheWayBackAndKeepsTheGap) {
  LandmarkScene scene = MakeLandmarkScene();
  const std::size_t num_out = scene.frames.size();
  for (std::size_t i = 0; i < num_out; ++i) {  // the same poses again
    const int idx = static_cast<int>(num_out + i);
    scene.frames.push_back(scene.frames[i]);
    scene.frames.back().frame_idx = idx;
    scene.poses.push_back(scene.poses[i]);
    scene.features.frames.push_back(scene.features.frames[i]);
    scene.features.frames.back().frame_idx = idx;
  }
  MatchesOptions options;
  options.loop_min_gap = 8;
  options.loop_stride = 1;
  Progress progress("test", false);
  const Vocabulary vocabulary = MakeSceneVocabulary(scene);
  const auto loops = MatchLoops(options, InputOf(scene), vocabulary, 2, progress);
  int num_exact = 0;
  for (const FramePair& loop : loops) {
    EXPECT_GE(loop.frame_b - loop.frame_a, options.loop_min_gap);
    num_exact += loop.frame_b - loop.frame_a == 8 && loop.status == PairStatus::kAccepted;
  }
  EXPECT_EQ(num_exact, 8);

  // Where only one frame finds a place, its neighbours do not bear it out.
  Vocabulary lonely = vocabulary;
  auto words = vocabulary.inverted_file.Words();
  for (std::size_t i = num_out; i < words.size(); ++i) {
    if (i != num_out + 3) words[i].clear();
  }
  lonely.inverted_file = InvertedFile(words);
  for (const FramePair& loop : MatchLoops(options, InputOf(scene), lonely, 2, progress)) {
    EXPECT_EQ(loop.frame_b, static_cast<int>(num_out) + 3);
    EXPECT_EQ(loop.status, PairStatus::kInconsistent);
  }

  options.loop_min_gap = 16;
  EXPECT_TRUE(MatchLoops(options, InputOf(scene), vocabulary, 2, progress).empty());
}

TEST(MatchLoops, RefusesAVocabularyOfOtherFeatures) {
  const LandmarkScene scene = MakeLandmarkScene();
  const auto expect_refused = [](const LandmarkScene& listed, const Vocabulary& vocabulary) {
    Progress progress("test", false);
    NIGHTMAP_EXPECT_ERROR(DataError,
                          MatchLoops({}, InputOf(listed), vocabulary, 1, progress),
                          "delete the vocabulary folder");
  };
  Vocabulary damaged = MakeSceneVocabulary(scene);
  auto words = damaged.inverted_file.Words();
  words[2].push_back(1);  // of a feature that the frame does not have
  damaged.inverted_file = InvertedFile(words);
  expect_refused(scene, damaged);
  LandmarkScene later = scene;
  for (FrameRecord& frame : later.frames) frame.frame_idx += 5;
  for (FrameFeatures& frame : later.features.frames) frame.frame_idx += 5;
  expect_refused(later, MakeSceneVocabulary(scene));
}

}  // namespace
}  // namespace nightmap
