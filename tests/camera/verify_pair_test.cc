// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/verify_pair.h"

#include <Eigen/LU>

#include "tests/landmark_scene.h"
#include "tests/test_data.h"

namespace nightmap::verify_pair_test {

FramePair Verify(const LandmarkScene& scene, const FrameFeatures& a, const FrameFeatures& b) {
  VerifyOptions options;
  options.pose.min_inliers = 15;
  FramePair pair;
  VerifyPair(options, a, scene.cameras[0], b, scene.cameras[0], &pair);
  return pair;
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

}  // namespace nightmap::verify_pair_test
