// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/schur_system.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>

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
  SchurSystem system(made.problem, true, 2);
  for (Eigen::Index k = 0; k < 6; ++k) {
    EXPECT_NEAR(system.CalibrationSigma(made.observations, made.priors, k),
                std::sqrt(covariance(first + k, first + k)),
                1e-6);
  }
}

TEST(SchurSystem, StepIsThatOfTheWholeSystem) {
  for (const bool has_calibrations : {false, true}) {
    for (std::uint64_t seed = 0; seed < 5; ++seed) {
      const Case made = RandomCase(seed);
      const DenseSystem dense = Dense(made, has_calibrations);
      Eigen::MatrixXd damped = dense.hessian;
      damped.diagonal() += dense.damping;
      const Eigen::VectorXd expected = -damped.ldlt().solve(dense.gradient);
      SchurSystem system(made.problem, has_calibrations, 2);
      const auto step = system.Solve(made.observations, made.priors, kTrust);
      ASSERT_TRUE(step);
      EXPECT_LT((Flat(*step) - expected).norm(), 1e-9 * expected.norm()) << seed;
      const double decrease =
          -dense.gradient.dot(expected) - 0.5 * expected.dot(dense.hessian * expected);
      EXPECT_NEAR(step->predicted_decrease, decrease, 1e-9 * decrease) << seed;
    }
  }
}

TEST(SchurSystem, SolvesAgainWithOtherNumbers) {
  const Case first = RandomCase(1);
  SchurSystem system(first.problem, true, 2);
  const auto before = system.Solve(first.observations, first.priors, kTrust);
  auto doubled = first.observations;
  for (LinearObservation& o : doubled) o.residual *= 2;
  auto priors = first.priors;
  for (LinearPrior& prior : priors) prior.gradient *= 2;
  const auto after = system.Solve(doubled, priors, kTrust);
  ASSERT_TRUE(before && after);
  EXPECT_LT((Flat(*after) - 2 * Flat(*before)).norm(), 1e-9 * Flat(*after).norm());
}

TEST(SchurSystem, SameBytesAtAnyNumberOfThreads) {
  const Case made = RandomCase(7);
  SchurSystem one(made.problem, true, 1);
  SchurSystem four(made.problem, true, 4);
  const auto by_one = one.Solve(made.observations, made.priors, kTrust);
  const auto by_four = four.Solve(made.observations, made.priors, kTrust);
  ASSERT_TRUE(by_one && by_four);
  EXPECT_EQ(Flat(*by_one), Flat(*by_four));
  EXPECT_EQ(by_one->predicted_decrease, by_four->predicted_decrease);
}

TEST(SchurSystem, OnlyPointsWhenEveryPoseIsFixed) {
  Case made = RandomCase(3);
  made.problem.is_fixed.assign(kNumPoses, true);
  SchurSystem system(made.problem, false, 1);
  const auto step = system.Solve(made.observations, made.priors, kTrust);
  ASSERT_TRUE(step);
  for (const Vector6d& pose : step->poses) EXPECT_EQ(pose, Vector6d::Zero());
  EXPECT_GT(step->points[0].norm(), 0);
  EXPECT_GT(step->predicted_decrease, 0);
}

TEST(SchurSystem, NothingWhenANumberIsNone) {
  Case made = RandomCase(4);
  made.observations[5].residual[0] = std::numeric_limits<double>::quiet_NaN();
  SchurSystem system(made.problem, true, 1);
  EXPECT_FALSE(system.Solve(made.observations, made.priors, kTrust));
}

}  // namespace nightmap::schur_system_test
