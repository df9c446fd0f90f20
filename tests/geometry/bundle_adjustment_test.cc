// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/bundle_adjustment.h"

#include <gtest/gtest.h>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"

namespace nightmap {
namespace {

const Camera kCamera{640, 480, 525, 525, 319.5, 239.5};

// Cameras moving sideways in front of a cloud of points, all observations exact.
BundleProblem ExactProblem() {
  Random random(1);
  BundleProblem problem;
  for (int i = 0; i < 5; ++i) {
    problem.camera_from_world.push_back(
        {Eigen::Quaterniond(Eigen::AngleAxisd(0.05 * i, Eigen::Vector3d::UnitY())),
         {-0.1 * i, 0.02 * i, 0}});
    problem.cameras.push_back(kCamera);
    problem.is_fixed.push_back(i == 0);
  }
  for (int k = 0; k < 100; ++k) {
    problem.points_in_world.push_back(
        {random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(2, 4)});
    for (int i = 0; i < 5; ++i) {
      const Eigen::Vector3d p =
          problem.camera_from_world[static_cast<std::size_t>(i)] * problem.points_in_world.back();
      problem.observations.push_back({i, k, *kCamera.ProjectUndistorted(p), p.z(), DepthNoise{}});
    }
  }
  return problem;
}

TEST(BundleAdjustment, ExactProblemStays) {
  BundleProblem problem = ExactProblem();
  EXPECT_LT(AdjustBundle({}, &problem).initial_cost, 1e-12);
}

TEST(BundleAdjustment, ReturnsFromADisturbedStart) {
  const BundleProblem truth = ExactProblem();
  BundleProblem problem = truth;
  Random random(2);
  const auto noise = [&] {
    return Eigen::Vector3d(random.Gaussian(), random.Gaussian(), random.Gaussian());
  };
  for (std::size_t i = 1; i < problem.camera_from_world.size(); ++i) {
    problem.camera_from_world[i].translation += 0.02 * noise();
  }
  for (Eigen::Vector3d& point : problem.points_in_world) point += 0.02 * noise();
  const BundleSummary summary = AdjustBundle({.max_iterations = 50}, &problem);
  EXPECT_LT(summary.final_cost, 1e-3 * summary.initial_cost);
  for (std::size_t i = 0; i < problem.camera_from_world.size(); ++i) {
    EXPECT_LT(
        (problem.camera_from_world[i].translation - truth.camera_from_world[i].translation).norm(),
        1e-3);
    EXPECT_LT(AngleBetween_rad(problem.camera_from_world[i], truth.camera_from_world[i]), 1e-3);
  }
}

TEST(BundleAdjustment, FixedPoseDoesNotMove) {
  BundleProblem problem = ExactProblem();
  problem.points_in_world[0].x() += 0.1;
  const Rigid3 before = problem.camera_from_world[0];
  AdjustBundle({}, &problem);
  EXPECT_EQ(before.Matrix(), problem.camera_from_world[0].Matrix());
}

TEST(BundleAdjustment, LeavesOutWhatIsBehindTheCamera) {
  const BundleProblem truth = ExactProblem();
  BundleProblem problem = truth;
  problem.points_in_world.push_back({0, 0, -2});
  const int behind = static_cast<int>(problem.points_in_world.size()) - 1;
  problem.observations.push_back({2, behind, {300, 200}, 2.0, DepthNoise{}});
  AdjustBundle({}, &problem);
  EXPECT_EQ(problem.observations.size(), truth.observations.size());
  EXPECT_LT((problem.camera_from_world[2].Matrix() - truth.camera_from_world[2].Matrix()).norm(),
            1e-6);
}

TEST(BundleAdjustment, RefusesSizesThatDoNotFit) {
  BundleProblem problem = ExactProblem();
  problem.is_fixed.pop_back();
  EXPECT_THROW(AdjustBundle({}, &problem), DataError);
}

}  // namespace
}  // namespace nightmap
