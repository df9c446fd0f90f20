// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/odometry/odometry.h"

#include <Eigen/Cholesky>

#include "stages/camera/odometry/initial_poses.h"
#include "tests/landmark_scene.h"
#include "tests/test_data.h"

namespace nightmap::odometry_test {

// A pair as the matches stage would write it, its pose off by noise.
FramePair MakePair(const LandmarkScene& scene, int a, int b, double noise_m) {
  Random random(5, static_cast<std::uint64_t>(a), static_cast<std::uint64_t>(b));
  FramePair pair;
  pair.frame_a = a;
  pair.frame_b = b;
  pair.status = PairStatus::kAccepted;
  pair.b_from_a = TrueRelative(scene, static_cast<std::size_t>(a), static_cast<std::size_t>(b));
  for (double& value : pair.b_from_a.translation) value += noise_m * random.Gaussian();
  pair.inliers = CommonPoints(scene, a, b);
  return pair;
}

// Pairs (b - 1, b) and (b - 2, b), sorted by (b, a).
std::vector<FramePair> MakePairs(const LandmarkScene& scene, double noise_m) {
  std::vector<FramePair> pairs;
  for (int b = 1; b < static_cast<int>(scene.frames.size()); ++b) {
    for (const int a : {b - 2, b - 1}) {
      if (a >= 0) pairs.push_back(MakePair(scene, a, b, noise_m));
    }
  }
  return pairs;
}

// Frames from `lost` on have no pair with earlier frames.
void CutBefore(int lost, std::vector<FramePair>* pairs) {
  for (FramePair& pair : *pairs) {
    if (pair.frame_a < lost && pair.frame_b >= lost) pair.status = PairStatus::kTooFewInliers;
  }
}

// One frame has no pair at all.
void Isolate(int lost, std::vector<FramePair>* pairs) {
  for (FramePair& pair : *pairs) {
    if (pair.frame_a == lost || pair.frame_b == lost) pair.status = PairStatus::kTooFewMatches;
  }
}

double Error_m(const LandmarkScene& scene, int idx, const Rigid3& first_from_camera) {
  const Rigid3 expected = TrueRelative(scene, static_cast<std::size_t>(idx), 0);
  return (expected.translation - first_from_camera.translation).norm();
}

TEST(ChainPoses, FollowsExactPairs) {
  const LandmarkScene scene = MakeLandmarkScene(400, 8);
  const auto frames = ChainPoses(MakePairs(scene, 0), 0, 0, 8);
  for (int i = 0; i < 8; ++i) {
    const ChainedFrame& frame = frames[static_cast<std::size_t>(i)];
    EXPECT_TRUE(frame.is_posed);
    EXPECT_EQ(frame.state, TrackingState::kTracked);
    EXPECT_LT(Error_m(scene, i, frame.shard_from_camera), 1e-9);
  }
}

TEST(ChainPoses, PutsALostFrameBetweenItsNeighbours) {
  const LandmarkScene scene = MakeLandmarkScene(400, 8);
  auto pairs = MakePairs(scene, 0);
  Isolate(4, &pairs);
  const auto frames = ChainPoses(pairs, 0, 0, 8);
  EXPECT_EQ(frames[4].state, TrackingState::kBridged);
  EXPECT_EQ(frames[5].state, TrackingState::kTracked);
  const Rigid3 middle = Interpolate(frames[3].shard_from_camera, frames[5].shard_from_camera, 0.5);
  EXPECT_LT((middle.translation - frames[4].shard_from_camera.translation).norm(), 1e-12);
  EXPECT_LT(Error_m(scene, 7, frames[7].shard_from_camera), 1e-9);
}

TEST(ChainPoses, GoesOnAfterACutAtTheLastVelocity) {
  const LandmarkScene scene = MakeLandmarkScene(400, 8);
  auto pairs = MakePairs(scene, 0);
  CutBefore(4, &pairs);
  const auto frames = ChainPoses(pairs, 0, 0, 8);
  EXPECT_EQ(frames[4].state, TrackingState::kStarted);
  EXPECT_EQ(frames[5].state, TrackingState::kTracked);
  // The scene moves at almost constant velocity, so the guess is near.
  EXPECT_LT(Error_m(scene, 4, frames[4].shard_from_camera), 0.05);
}

TEST(Interpolate, EndsAreThePoses) {
  const Rigid3 a = ScenePose(0, 0.2);
  const Rigid3 b = ScenePose(1, -0.4);
  EXPECT_LT((Interpolate(a, b, 0).Matrix() - a.Matrix()).norm(), 1e-12);
  EXPECT_LT((Interpolate(a, b, 1).Matrix() - b.Matrix()).norm(), 1e-12);
  EXPECT_NEAR(AngleBetween_rad(Interpolate(a, b, 0.25), a), 0.15, 1e-12);
}

class OdometryTest : public testing::Test {
 protected:
  OdometryShard Run(const std::vector<FramePair>& pairs,
                    int first_frame_idx = 0,
                    const OdometryOptions& options = {}) const {
    return RunOdometry(options,
                       {scene_.frames, scene_.cameras, scene_.features, pairs, first_frame_idx},
                       NoProgress())
        .shard;
  }
  double WorstError_m(const OdometryShard& shard) const {
    double worst = 0;
    for (const OdometryFrame& frame : shard.frames) {
      worst = std::max(worst, Error_m(scene_, frame.frame_idx, frame.shard_from_camera));
    }
    return worst;
  }
  // Another point seen in a frame; the index of its feature.
  int AddFeature(std::size_t frame, const Eigen::Vector3d& point) {
    const Eigen::Vector3d in_camera = scene_.poses[frame].pose.Inverse() * point;
    FrameFeatures& features = scene_.features.frames[frame];
    features.keypoints_px.push_back(
        scene_.cameras[0].color.ProjectUndistorted(in_camera)->cast<float>());
    features.depths_m.push_back(static_cast<float>(in_camera.z()));
    return features.NumFeatures() - 1;
  }

  LandmarkScene scene_ = MakeLandmarkScene(600, 10);
};

TEST_F(OdometryTest, AdjustmentRemovesTheNoiseOfThePairs) {
  const auto pairs = MakePairs(scene_, 0.03);
  const auto chained = ChainPoses(pairs, 0, 0, 10);
  ASSERT_GT(Error_m(scene_, 9, chained[9].shard_from_camera), 0.02);
  const OdometryShard shard = Run(pairs);
  ASSERT_EQ(shard.frames.size(), 10U);
  for (const OdometryFrame& frame : shard.frames) {
    EXPECT_LT(Error_m(scene_, frame.frame_idx, frame.shard_from_camera), 0.002);
  }
}

// Two panels that look alike, 0.9 m apart, one seen early, the other in frame 7: three pairs whose
// inliers agree with each other, on a wrong pose.
TEST_F(OdometryTest, FalsePairsDoNotTearTheTracks) {
  auto pairs = MakePairs(scene_, 0.001);
  for (FramePair& pair : pairs) pair.inliers.resize(120);
  Random random(12);
  for (const int early : {1, 2, 3}) {
    FramePair wrong = MakePair(scene_, early, 7, 0);
    wrong.inliers.clear();
    const auto a = static_cast<std::size_t>(early);
    const Eigen::Vector3d shift(0.9, 0, 0);
    wrong.b_from_a = scene_.poses[7].pose.Inverse() *
                     Rigid3{Eigen::Quaterniond::Identity(), shift} * scene_.poses[a].pose;
    for (int i = 0; i < 119; ++i) {
      const Eigen::Vector3d panel(random.Uniform(-1, 0), random.Uniform(-1, 1), 4);
      const int in_a = AddFeature(a, panel);
      wrong.inliers.push_back({in_a, AddFeature(7, panel + shift)});
    }
    pairs.insert(std::ranges::lower_bound(pairs, 7, {}, &FramePair::frame_b), wrong);
  }
  OdometryOptions trusting;
  trusting.max_pair_error_m = 100;
  EXPECT_LT(WorstError_m(Run(pairs)), 0.01);
  EXPECT_GT(WorstError_m(Run(pairs, 0, trusting)), 0.05);
}

TEST_F(OdometryTest, EdgesJoinConsecutiveKeyframes) {
  const OdometryShard shard = Run(MakePairs(scene_, 0));
  std::vector<int> keyframes;
  for (const OdometryFrame& frame : shard.frames) {
    if (frame.is_keyframe) keyframes.push_back(frame.frame_idx);
  }
  ASSERT_GE(keyframes.size(), 2U);
  EXPECT_EQ(keyframes.front(), 0);
  EXPECT_EQ(keyframes.back(), 9);
  ASSERT_EQ(shard.edges.size(), keyframes.size() - 1);
  for (std::size_t i = 0; i < shard.edges.size(); ++i) {
    const PoseEdge& edge = shard.edges[i];
    EXPECT_EQ(edge.frame_a, keyframes[i]);
    EXPECT_EQ(edge.frame_b, keyframes[i + 1]);
    EXPECT_FALSE(edge.is_bridge);
    EXPECT_EQ(Eigen::LLT<Matrix6d>(edge.covariance).info(), Eigen::Success);
    EXPECT_LT(edge.covariance.diagonal().tail<3>().maxCoeff(), 0.01 * 0.01);
  }
}

TEST_F(OdometryTest, EveryFrameOfACutRecordingHasAPoseAndTheGapIsHeldLoosely) {
  auto pairs = MakePairs(scene_, 0);
  CutBefore(5, &pairs);
  const OdometryShard shard = Run(pairs);
  ASSERT_EQ(shard.frames.size(), 10U);
  EXPECT_EQ(shard.frames[5].state, TrackingState::kStarted);
  EXPECT_TRUE(shard.frames[5].is_keyframe);
  int num_bridges = 0;
  for (const PoseEdge& edge : shard.edges) {
    num_bridges += edge.is_bridge;
    EXPECT_EQ(edge.is_bridge, edge.frame_a < 5 && edge.frame_b >= 5);
    if (edge.is_bridge) {
      EXPECT_GE(edge.covariance(3, 3), 1);  // a second without tracking
    }
  }
  EXPECT_EQ(num_bridges, 1);
}

TEST_F(OdometryTest, NoPairAtAllStillGivesEveryFrameAPose) {
  auto pairs = MakePairs(scene_, 0);
  for (FramePair& pair : pairs) pair.status = PairStatus::kTooFewMatches;
  const OdometryShard shard = Run(pairs);
  ASSERT_EQ(shard.frames.size(), 10U);
  for (std::size_t i = 1; i < 10; ++i) {
    EXPECT_EQ(shard.frames[i].state, TrackingState::kBridged);
    EXPECT_TRUE(shard.frames[i].shard_from_camera.Matrix().allFinite());
  }
}

TEST_F(OdometryTest, ALaterShardHangsOnTheLastFrameOfTheOneBefore) {
  auto pairs = MakePairs(scene_, 0.01);
  std::erase_if(pairs, [](const FramePair& pair) { return pair.frame_b < 6; });
  const OdometryShard shard = Run(pairs, 6);
  ASSERT_EQ(shard.frames.size(), 4U);
  EXPECT_EQ(shard.frames[0].frame_idx, 6);
  ASSERT_FALSE(shard.edges.empty());
  const PoseEdge& first = shard.edges[0];
  EXPECT_EQ(first.frame_a, 5);
  const Rigid3 expected = TrueRelative(scene_, 5, static_cast<std::size_t>(first.frame_b));
  EXPECT_LT((first.b_from_a.translation - expected.translation).norm(), 0.002);
}

// Frames between described ones, with pixels off by noise.
TEST_F(OdometryTest, TrackedFramesLieOnThePointsOfTheDescribedOnes) {
  for (const int idx : {1, 2, 4, 5, 7, 8}) TrackFrom(idx / 3 * 3, idx, &scene_);
  Random random(4);
  for (FrameFeatures& frame : scene_.features.frames) {
    for (auto& pixel : frame.keypoints_px) {
      pixel.x() += static_cast<float>(0.3 * random.Gaussian());
      pixel.y() += static_cast<float>(0.3 * random.Gaussian());
    }
  }
  std::vector<FramePair> pairs;
  for (int b = 1; b < 10; ++b) pairs.push_back(MakePair(scene_, (b - 1) / 3 * 3, b, 0.03));
  const OdometryShard shard = Run(pairs);
  EXPECT_LT(WorstError_m(shard), 0.004);
  for (const OdometryFrame& frame : shard.frames) {
    EXPECT_EQ(frame.state, TrackingState::kTracked);
    EXPECT_TRUE(frame.frame_idx % 3 == 0 || !frame.is_keyframe);
  }
}

TEST_F(OdometryTest, RefusesPairsOfOtherFrames) {
  auto pairs = MakePairs(scene_, 0);
  pairs.back().frame_b = 10;
  NIGHTMAP_EXPECT_ERROR(DataError, Run(pairs), "outside the given frames");
}

TEST_F(OdometryTest, RefusesPairsThatAreNotSortedOrNameNoFeature) {
  auto pairs = MakePairs(scene_, 0);
  std::swap(pairs.front(), pairs.back());
  NIGHTMAP_EXPECT_ERROR(DataError, Run(pairs), "not sorted by their second frame");
  pairs = MakePairs(scene_, 0);
  pairs[1].inliers[0].b = 1'000'000;
  NIGHTMAP_EXPECT_ERROR(DataError, Run(pairs), "feature 1000000 of frame");
}

}  // namespace nightmap::odometry_test
