// SPDX-License-Identifier: Apache-2.0
// Both minimal solvers in RANSAC: exact, among outliers, and where there is no pose to find.
#include <gtest/gtest.h>

#include "tests/geometry/pose_matches.h"

namespace nightmap::robust_pose_test {

// Features half a pixel off, and `num_outliers` of them anywhere.
void Disturb(int num_outliers, Random& random, std::vector<PointMatch>* matches) {
  for (std::size_t i = 0; i < matches->size(); ++i) {
    Eigen::Vector2d& pixel = (*matches)[i].pixel;
    pixel += Eigen::Vector2d(random.Gaussian(), random.Gaussian()) * 0.5;
    if (static_cast<int>(i) < num_outliers) {
      pixel = {random.Uniform(0, 639), random.Uniform(0, 479)};
    }
  }
}

double DistanceBetween_m(const Rigid3& a, const Rigid3& b) {
  return (a.Inverse().translation - b.Inverse().translation).norm();
}

// Number of problems solved out of five with 200 matches each.
int NumSolved(MinimalSolver solver, int outlier_percent, int max_iterations) {
  int num_solved = 0;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    Random random(seed);
    const Rigid3 truth = RandomPose(random);
    auto matches = MakeMatches(truth, 200, 0, random);
    Disturb(2 * outlier_percent, random, &matches);
    const auto pose = EstimateAbsolutePose(
        kCamera, matches, {.solver = solver, .max_iterations = max_iterations, .seed = seed});
    num_solved += pose && DistanceBetween_m(pose->camera_from_world, truth) < 0.02 &&
                  AngleBetween_rad(pose->camera_from_world, truth) < 0.01;
  }
  return num_solved;
}

class SolverTest : public testing::TestWithParam<MinimalSolver> {
 protected:
  AbsolutePoseOptions Options(int min_inliers, std::uint64_t seed = 0) const {
    return {.solver = GetParam(), .min_inliers = min_inliers, .seed = seed};
  }
  bool IsDlt() const { return GetParam() == MinimalSolver::kDlt6; }
};

// The solver alone, without refinement.
TEST_P(SolverTest, IsExactForExactMatches) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Random random(seed);
    const Rigid3 truth = RandomPose(random);
    AbsolutePoseOptions options = Options(30, seed);
    options.local_optimization = options.refinement = false;
    const auto pose = EstimateAbsolutePose(kCamera, MakeMatches(truth, 30, 0, random), options);
    ASSERT_TRUE(pose) << seed;
    EXPECT_LT(DistanceBetween_m(pose->camera_from_world, truth), 1e-5) << seed;
    EXPECT_LT(AngleBetween_rad(pose->camera_from_world, truth), 1e-5) << seed;
  }
}

TEST_P(SolverTest, SurvivesHalfOfTheMatchesWrong) {
  EXPECT_EQ(NumSolved(GetParam(), 30, 2000), 5);
  EXPECT_EQ(NumSolved(GetParam(), 50, 2000), 5);
}

// The fewest matches that differ from chance, and one fewer.
TEST_P(SolverTest, NeedsOneMatchMoreThanItsSample) {
  const int sample_size = IsDlt() ? 6 : 3;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    const Rigid3 truth = RandomPose(random);
    const auto matches = MakeMatches(truth, sample_size + 1, 0, random);
    const auto pose = EstimateAbsolutePose(kCamera, matches, Options(sample_size + 1, seed));
    ASSERT_TRUE(pose) << seed;
    EXPECT_LT(DistanceBetween_m(pose->camera_from_world, truth), 1e-3) << seed;
    for (int count = 0; count <= sample_size; ++count) {
      const std::vector<PointMatch> few(matches.begin(), matches.begin() + count);
      EXPECT_FALSE(EstimateAbsolutePose(kCamera, few, Options(count))) << count;
    }
  }
}

// Any rotation of the pose about the line fits equally well.
TEST_P(SolverTest, RefusesPointsOnALine) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    const Rigid3 truth = RandomPose(random);
    const Eigen::Vector3d a = RandomPoint(random);
    const Eigen::Vector3d b = RandomPoint(random);
    std::vector<PointMatch> matches;
    for (int i = 0; i < 40; ++i) {
      matches.push_back(MatchOf(truth, a + random.Uniform(0, 1) * (b - a)));
    }
    EXPECT_FALSE(EstimateAbsolutePose(kCamera, matches, Options(12, seed))) << seed;
  }
}

TEST_P(SolverTest, RefusesOnePointManyTimes) {
  Random random(4);
  const Rigid3 truth = RandomPose(random);
  const std::vector<PointMatch> matches(40, MatchOf(truth, RandomPoint(random)));
  EXPECT_FALSE(EstimateAbsolutePose(kCamera, matches, Options(12)));
}

// Six points of a plane do not determine the DLT's matrix; three determine P3P's poses.
TEST_P(SolverTest, APlaneIsEnoughForThreePointsOnly) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Random random(seed);
    const Rigid3 truth = RandomPose(random);
    const Eigen::Hyperplane<double, 3> plane(
        Eigen::Vector3d(random.Uniform(-0.5, 0.5), random.Uniform(-0.5, 0.5), 1).normalized(),
        Eigen::Vector3d(0, 0, 3));
    std::vector<PointMatch> matches;
    for (int i = 0; i < 40; ++i) {
      const Eigen::Vector3d ray = RandomPoint(random);
      matches.push_back(MatchOf(truth, ray * (-plane.offset() / plane.normal().dot(ray))));
    }
    const auto pose = EstimateAbsolutePose(kCamera, matches, Options(12, seed));
    EXPECT_EQ(pose.has_value(), !IsDlt()) << seed;
    if (pose) {
      EXPECT_LT(DistanceBetween_m(pose->camera_from_world, truth), 1e-4) << seed;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers,
                         SolverTest,
                         testing::Values(MinimalSolver::kP3p, MinimalSolver::kDlt6),
                         [](const auto& solver) {
                           return solver.param == MinimalSolver::kDlt6 ? "Dlt6" : "P3p";
                         });

// A sample of three is clean in 1 of 1000 where 90 % are wrong, one of six in 1 of 1,000,000.
TEST(RobustPose, P3pSurvivesNineOfTenWrong) {
  EXPECT_EQ(NumSolved(MinimalSolver::kP3p, 70, 2000), 5);
  EXPECT_EQ(NumSolved(MinimalSolver::kP3p, 90, 20000), 5);
}

TEST(RobustPose, DltNeedsManyIterationsForSevenOfTenWrong) {
  EXPECT_EQ(NumSolved(MinimalSolver::kDlt6, 70, 20000), 5);
}

}  // namespace nightmap::robust_pose_test
