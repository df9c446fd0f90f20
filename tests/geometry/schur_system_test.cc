// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/schur_system.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>
#include <utility>

#include "pipeline/base/random.h"

namespace nightmap::schur_system_test {

constexpr int kNumPoses = 9;
constexpr int kNumPoints = 60;
constexpr double kTrust = 50;

// Poses along a line that see the points around them, two sensors in turn, one pose fixed, one that
// sees nothing, and a point that nothing sees.
struct Case {
  BundleProblem problem;
  std::vector<LinearObservation> observations;
  std::vector<LinearPrior> priors;
};

Case RandomCase(std::uint64_t seed) {
  Random random(seed);
  Case made;
  BundleProblem& problem = made.problem;
  problem.camera_from_world.resize(kNumPoses);
  problem.cameras.resize(kNumPoses);
  problem.is_fixed.assign(kNumPoses, false);
  problem.is_fixed[2] = true;
  problem.points_in_world.resize(kNumPoints);
  problem.calibrations.resize(2);
  for (int i = 0; i < kNumPoses; ++i) problem.sensor_idx.push_back(i % 2);
  for (int k = 0; k + 1 < kNumPoints; ++k) {
    const int first = static_cast<int>(random.Index(kNumPoses - 3));
    for (int i = first; i < first + 3; ++i) {
      problem.observations.push_back({i, k, Eigen::Vector2d::Zero(), 0, DepthNoise{}});
      LinearObservation linear;
      for (double& value : linear.jacobian.by_pose.reshaped()) value = random.Gaussian();
      for (double& value : linear.jacobian.by_point.reshaped()) value = random.Gaussian();
      for (double& value : linear.jacobian.by_calibration.reshaped()) value = random.Gaussian();
      for (double& value : linear.residual) value = random.Gaussian();
      made.observations.push_back(linear);
    }
  }
  made.priors.assign(2, {{3, 4, 5}, {0.1, -0.2, 0.3}});
  return made;
}

SchurSystem System(const Case& made,
                   bool has_calibrations = true,
                   int num_threads = 2,
                   std::size_t max_part = SchurSystem::kMaxPart) {
  const auto linearize = [&](std::size_t i) { return made.observations[i]; };
  return {made.problem, has_calibrations, num_threads, linearize, max_part};
}

// The whole damped system at once: poses, points, calibrations.
struct DenseSystem {
  Eigen::MatrixXd hessian;
  Eigen::VectorXd gradient;
  Eigen::VectorXd damping;
};

DenseSystem Dense(const Case& made, bool has_calibrations) {
  constexpr int kFirstPoint = 6 * kNumPoses;
  constexpr int kFirstCalibration = kFirstPoint + 3 * kNumPoints;
  constexpr int kSize = kFirstCalibration + 6;
  DenseSystem dense{Eigen::MatrixXd::Zero(kSize, kSize),
                    Eigen::VectorXd::Zero(kSize),
                    Eigen::VectorXd::Zero(kSize)};
  for (std::size_t o = 0; o < made.observations.size(); ++o) {
    const BundleObservation& observation = made.problem.observations[o];
    const auto& [jacobian, residual] = made.observations[o];
    Eigen::Matrix3Xd row = Eigen::Matrix3Xd::Zero(3, kSize);
    if (!made.problem.is_fixed[static_cast<std::size_t>(observation.pose_idx)]) {
      row.middleCols<6>(6 * observation.pose_idx) = jacobian.by_pose;
    }
    row.middleCols<3>(kFirstPoint + 3 * observation.point_idx) = jacobian.by_point;
    if (has_calibrations) {
      row.middleCols<3>(kFirstCalibration + 3 * (observation.pose_idx % 2)) =
          jacobian.by_calibration;
    }
    dense.hessian += row.transpose() * row;
    dense.gradient += row.transpose() * residual;
  }
  for (int sensor = 0; has_calibrations && sensor < 2; ++sensor) {
    const auto& [diagonal, gradient] = made.priors[static_cast<std::size_t>(sensor)];
    dense.hessian.diagonal().segment<3>(kFirstCalibration + 3 * sensor) += diagonal;
    dense.gradient.segment<3>(kFirstCalibration + 3 * sensor) += gradient;
  }
  dense.damping = dense.hessian.diagonal().cwiseMax(1e-6) / kTrust;
  return dense;
}

Eigen::VectorXd Flat(const BundleStep& step) {
  std::vector<double> values;
  for (const auto& pose : step.poses) values.insert(values.end(), pose.begin(), pose.end());
  for (const auto& point : step.points) values.insert(values.end(), point.begin(), point.end());
  for (const auto& c : step.calibrations) values.insert(values.end(), c.begin(), c.end());
  return Eigen::Map<Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

TEST(SchurSystem, SigmasAreThoseOfTheWholeSystem) {
  const Case made = RandomCase(1);
  DenseSystem dense = Dense(made, true);
  // Unknowns that no observation determines are held by the damping; keep the others exact.
  dense.hessian.diagonal() += 1e-12 * dense.hessian.diagonal().cwiseMax(1e-6);
  const Eigen::Index first = dense.hessian.rows() - 6;
  const Eigen::MatrixXd covariance = dense.hessian.inverse();
  SchurSystem system = System(made);
  for (Eigen::Index k = 0; k < 6; ++k) {
    EXPECT_NEAR(
        system.CalibrationSigma(made.priors, k), std::sqrt(covariance(first + k, first + k)), 1e-6);
  }
}

TEST(SchurSystem, StepIsThatOfTheWholeSystem) {
  for (const bool has_calibrations : {false, true}) {
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
      const Case made = RandomCase(seed);
      const std::size_t max_part = seed < 4 ? SchurSystem::kMaxPart : 10 * (seed - 3);
      const DenseSystem dense = Dense(made, has_calibrations);
      Eigen::MatrixXd damped = dense.hessian;
      damped.diagonal() += dense.damping;
      const Eigen::VectorXd expected = -damped.ldlt().solve(dense.gradient);
      SchurSystem system = System(made, has_calibrations, 2, max_part);
      const auto step = system.Solve(made.priors, kTrust);
      ASSERT_TRUE(step);
      EXPECT_LT((Flat(*step) - expected).norm(), 1e-9 * expected.norm()) << seed;
      const double decrease =
          -dense.gradient.dot(expected) - 0.5 * expected.dot(dense.hessian * expected);
      EXPECT_NEAR(step->predicted_decrease, decrease, 1e-9 * decrease) << seed;
    }
  }
}

TEST(SchurSystem, SolvesAgainWithOtherNumbers) {
  for (const std::size_t max_part : {SchurSystem::kMaxPart, std::size_t{20}}) {
    Case made = RandomCase(1);
    SchurSystem system = System(made, true, 2, max_part);
    const auto before = system.Solve(made.priors, kTrust);
    for (LinearObservation& o : made.observations) o.residual *= 2;
    for (LinearPrior& prior : made.priors) prior.gradient *= 2;
    system.EstimateMoved();
    const auto after = system.Solve(made.priors, kTrust);
    ASSERT_TRUE(before && after);
    EXPECT_LT((Flat(*after) - 2 * Flat(*before)).norm(), 1e-9 * Flat(*after).norm());
  }
}

TEST(SchurSystem, SameBytesAtAnyNumberOfThreads) {
  const Case made = RandomCase(7);
  for (const std::size_t max_part : {SchurSystem::kMaxPart, std::size_t{20}}) {
    const auto by_one = System(made, true, 1, max_part).Solve(made.priors, kTrust);
    const auto by_four = System(made, true, 4, max_part).Solve(made.priors, kTrust);
    ASSERT_TRUE(by_one && by_four);
    EXPECT_EQ(Flat(*by_one), Flat(*by_four));
    EXPECT_EQ(by_one->predicted_decrease, by_four->predicted_decrease);
  }
}

// Each point is of one range, with all its observations.
TEST(SchurSystem, RangesCoverAllOnce) {
  BundleProblem problem = RandomCase(2).problem;
  problem.points_in_world.resize(kNumPoints + 3);  // nothing sees the last ones
  for (const std::size_t max_observations : {1, 7, 50, 1000}) {
    const auto ranges = CutIntoRanges(problem, max_observations);
    EXPECT_EQ(ranges.front().begin, 0U);
    EXPECT_EQ(ranges.front().first_point, 0U);
    EXPECT_EQ(ranges.back().end, problem.observations.size());
    EXPECT_EQ(ranges.back().end_point, problem.points_in_world.size());
    for (std::size_t i = 0; i < ranges.size(); ++i) {
      if (i > 0) {
        EXPECT_EQ(ranges[i].begin, ranges[i - 1].end);
        EXPECT_EQ(ranges[i].first_point, ranges[i - 1].end_point);
      }
      EXPECT_LE(ranges[i].end - ranges[i].begin, max_observations + 2);
      for (std::size_t o = ranges[i].begin; o < ranges[i].end; ++o) {
        const auto point = static_cast<std::size_t>(problem.observations[o].point_idx);
        EXPECT_GE(point, ranges[i].first_point);
        EXPECT_LT(point, ranges[i].end_point);
      }
    }
  }
  std::swap(problem.observations.front(), problem.observations.back());
  EXPECT_EQ(CutIntoRanges(problem, 10).size(), 1U);
}

TEST(SchurSystem, OnlyPointsWhenEveryPoseIsFixed) {
  Case made = RandomCase(3);
  made.problem.is_fixed.assign(kNumPoses, true);
  SchurSystem system = System(made, false, 1);
  const auto step = system.Solve(made.priors, kTrust);
  ASSERT_TRUE(step);
  for (const Vector6d& pose : step->poses) EXPECT_EQ(pose, Vector6d::Zero());
  EXPECT_GT(step->points[0].norm(), 0);
  EXPECT_GT(step->predicted_decrease, 0);
}

TEST(SchurSystem, NothingWhenANumberIsNone) {
  Case made = RandomCase(4);
  made.observations[5].residual[0] = std::numeric_limits<double>::quiet_NaN();
  SchurSystem system = System(made, true, 1);
  EXPECT_FALSE(system.Solve(made.priors, kTrust));
}

}  // namespace nightmap::schur_system_test
