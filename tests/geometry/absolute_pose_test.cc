// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/absolute_pose.h"

#include <gtest/gtest.h>

#include "tests/geometry/pose_matches.h"

namespace nightmap::absolute_pose_test {

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

// Two motions share the matches; the one of fewer matches, and of more weight, is found.
TEST(AbsolutePose, WeightsSayWhichMatchesCount) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    const Rigid3 heavy = RandomPose(random);
    const Rigid3 light = RandomPose(random);
    auto matches = MakeMatches(heavy, 40, 0, random);
    const auto others = MakeMatches(light, 120, 0, random);
    matches.insert(matches.end(), others.begin(), others.end());
    std::vector<double> weights(matches.size(), 1);
    std::fill_n(weights.begin(), 40, 5);
    const auto pose = EstimateAbsolutePose(kCamera, matches, {.seed = seed}, weights);
    ASSERT_TRUE(pose.has_value());
    EXPECT_LT(AngleBetween_rad(pose->camera_from_world, heavy), 1e-3) << seed;
    const auto most = EstimateAbsolutePose(kCamera, matches, {.seed = seed});
    ASSERT_TRUE(most.has_value());
    EXPECT_LT(AngleBetween_rad(most->camera_from_world, light), 1e-3) << seed;
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

// The information of exact matches is J^T J; J here by central differences of the residuals.
TEST(AbsolutePose, InformationIsThatOfFiniteDifferences) {
  Random random(5);
  const Rigid3 truth = RandomPose(random);
  auto matches = MakeMatches(truth, 50, 0, random);
  for (std::size_t i = 0; i < matches.size(); i += 2) {
    matches[i].depth_m = (truth * matches[i].point_in_world).z();
    matches[i].point_sigma_m = 0.01;
  }
  const AbsolutePoseOptions options{.pixel_sigma_px = 0.8};
  const auto residuals = [&](const Eigen::Matrix<double, 6, 1>& step) {
    const Rigid3 camera_from_world =
        Rigid3{Eigen::Quaterniond(1, step[0] / 2, step[1] / 2, step[2] / 2).normalized(),
               step.tail<3>()} *
        truth;
    Eigen::VectorXd values = Eigen::VectorXd::Zero(150);
    for (int i = 0; i < 50; ++i) {
      const PointMatch& match = matches[static_cast<std::size_t>(i)];
      const Eigen::Vector3d p = camera_from_world * match.point_in_world;
      values.segment<2>(3 * i) =
          (*kCamera.ProjectUndistorted(p) - match.pixel) / options.pixel_sigma_px;
      if (match.depth_m == 0) continue;
      values[3 * i + 2] =
          (p.z() - match.depth_m) / std::hypot(options.noise.Sigma_m(match.depth_m), 0.01);
    }
    return values;
  };
  Eigen::MatrixXd jacobian(150, 6);
  for (int k = 0; k < 6; ++k) {
    const Eigen::Matrix<double, 6, 1> step = 1e-6 * Eigen::Matrix<double, 6, 1>::Unit(k);
    jacobian.col(k) = (residuals(step) - residuals(-step)) / 2e-6;
  }
  const auto covariance = PoseCovariance(kCamera, matches, truth, options);
  ASSERT_TRUE(covariance.has_value());
  const Matrix6d identity = *covariance * (jacobian.transpose() * jacobian);
  EXPECT_LT((identity - Matrix6d::Identity()).cwiseAbs().maxCoeff(), 1e-4);
}

TEST(AbsolutePose, MovingTheWorldMovesThePose) {
  Random random(6);
  const Rigid3 moved_from_world = RandomPose(random);
  auto matches = MakeMatches(RandomPose(random), 80, 20, random);
  const auto pose = EstimateAbsolutePose(kCamera, matches, {.seed = 1});
  for (PointMatch& match : matches) match.point_in_world = moved_from_world * match.point_in_world;
  const auto moved = EstimateAbsolutePose(kCamera, matches, {.seed = 1});
  ASSERT_TRUE(pose && moved);
  EXPECT_LT(
      ((moved->camera_from_world * moved_from_world).Matrix() - pose->camera_from_world.Matrix())
          .norm(),
      1e-6);
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

}  // namespace nightmap::absolute_pose_test
