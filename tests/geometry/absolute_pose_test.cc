// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/absolute_pose.h"

#include <gtest/gtest.h>

#include "pipeline/base/random.h"

namespace nightmap {
namespace {

const Camera kCamera{640, 480, 525, 525, 319.5, 239.5};

Rigid3 RandomPose(Random& random) {
  const Eigen::Vector3d axis(random.Gaussian(), random.Gaussian(), random.Gaussian());
  return {Eigen::Quaterniond(Eigen::AngleAxisd(random.Uniform(-0.5, 0.5), axis.normalized())),
          {random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(-1, 1)}};
}

// Matches of which the first num_outliers have a pixel that fits nothing.
std::vector<PointMatch> MakeMatches(const Rigid3& camera_from_world,
                                    int num_matches,
                                    int num_outliers,
                                    Random& random) {
  std::vector<PointMatch> matches;
  for (int i = 0; i < num_matches; ++i) {
    const Eigen::Vector2d pixel(random.Uniform(0, 639), random.Uniform(0, 479));
    const double depth_m = random.Uniform(1, 4);
    const Eigen::Vector3d point =
        camera_from_world.Inverse() * kCamera.BackProjectUndistorted(pixel, depth_m);
    const Eigen::Vector2d wrong(random.Uniform(0, 639), random.Uniform(0, 479));
    matches.push_back({i < num_outliers ? wrong : pixel, point, 0, 0});
  }
  return matches;
}

TEST(AbsolutePose, RecoversPosesAmongOutliers) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    const Rigid3 truth = RandomPose(random);
    const auto matches = MakeMatches(truth, 100, 50, random);
    const auto pose = EstimateAbsolutePose(kCamera, matches, {.seed = seed});
    ASSERT_TRUE(pose.has_value());
    EXPECT_LT((pose->camera_from_world.translation - truth.translation).norm(), 1e-3);
    EXPECT_LT(AngleBetween_rad(pose->camera_from_world, truth), 1e-3);
    EXPECT_GE(pose->inliers.size(), 50U);
    EXPECT_LT(pose->inliers.size(), 60U);
  }
}

TEST(AbsolutePose, RefusesMatchesWithoutAPose) {
  Random random(7);
  const auto matches = MakeMatches(RandomPose(random), 60, 60, random);
  EXPECT_FALSE(EstimateAbsolutePose(kCamera, matches, {.min_inliers = 15}).has_value());
  EXPECT_FALSE(EstimateAbsolutePose(kCamera, {}, {}).has_value());
}

TEST(AbsolutePose, SameSeedGivesTheSamePose) {
  Random random(3);
  const auto matches = MakeMatches(RandomPose(random), 80, 30, random);
  const auto first = EstimateAbsolutePose(kCamera, matches, {.seed = 5});
  const auto second = EstimateAbsolutePose(kCamera, matches, {.seed = 5});
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->camera_from_world.Matrix(), second->camera_from_world.Matrix());
  EXPECT_EQ(first->inliers, second->inliers);
}

TEST(AbsolutePose, DepthThatDisagreesIsNoInlier) {
  Random random(11);
  const Rigid3 truth = RandomPose(random);
  auto matches = MakeMatches(truth, 60, 0, random);
  for (PointMatch& match : matches) match.depth_m = (truth * match.point_in_world).z();
  matches[4].depth_m *= 2;
  const auto pose = EstimateAbsolutePose(kCamera, matches, {});
  ASSERT_TRUE(pose.has_value());
  EXPECT_EQ(pose->inliers.size(), 59U);
  EXPECT_EQ(std::ranges::count(pose->inliers, 4), 0);
}

TEST(AbsolutePose, CovarianceShrinksWithMoreMatches) {
  Random random(2);
  const Rigid3 truth = RandomPose(random);
  const auto many = MakeMatches(truth, 400, 0, random);
  const std::vector<PointMatch> few(many.begin(), many.begin() + 40);
  const auto wide = PoseCovariance(kCamera, few, truth, {});
  const auto narrow = PoseCovariance(kCamera, many, truth, {});
  ASSERT_TRUE(wide && narrow);
  EXPECT_LT(narrow->trace(), wide->trace() / 4);
  EXPECT_FALSE(PoseCovariance(kCamera, {few[0]}, truth, {}).has_value());
}

}  // namespace
}  // namespace nightmap
