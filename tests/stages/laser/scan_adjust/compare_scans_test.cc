// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_adjust/compare_scans.h"

#include <gtest/gtest.h>

#include <functional>
#include <optional>

#include "pipeline/recording/scan_points.h"
#include "tests/laser_building.h"

namespace nightmap::compare_scans_test {

constexpr double kSigma_m = 0.03;
constexpr double kStep = 1e-6;

const Building kRoom{{{-4, -3}, {4, 3}}, {{1.5, 1}, {2.5, 1.8}}, {{-2, -2.5}, {-1.2, -1}}};

std::vector<WallPoint> WallsFrom(const Rigid2& pose, double noise_m = 0) {
  const Signal scans = ScansAt(kRoom, {pose}, noise_m);
  std::vector<Eigen::Vector2d> points;
  for (const Eigen::Vector3d& point : PointsInRobot(scans.samples[0], scans).points_in_robot) {
    points.push_back(point.head<2>());
  }
  return FindWallPoints(points, 0.05);
}

Rigid2 RandomPose(Random& random, double range_m, double range_rad) {
  return {random.Uniform(-range_rad, range_rad),
          {random.Uniform(-range_m, range_m), random.Uniform(-range_m, range_m)}};
}

Rigid2 Added(const Rigid2& pose, const Eigen::Vector3d& step) {
  return {pose.heading_rad + step[2], pose.translation + step.head<2>()};
}

// A point's match, by the definition in the header.
std::optional<std::size_t> MatchOf(const WallPoint& point,
                                   const Rigid2& target_from_scan,
                                   const std::vector<WallPoint>& target,
                                   double gate_m) {
  const Eigen::Vector2d at = target_from_scan * point.point_in_robot;
  std::size_t best = 0;
  for (std::size_t i = 0; i < target.size(); ++i) {
    if ((target[i].point_in_robot - at).norm() < (target[best].point_in_robot - at).norm()) {
      best = i;
    }
  }
  const Eigen::Vector2d normal =
      Eigen::Rotation2Dd(target_from_scan.heading_rad) * point.normal_in_robot;
  if ((target[best].point_in_robot - at).norm() > gate_m) return std::nullopt;
  if (normal.dot(target[best].normal_in_robot) < 0.9) return std::nullopt;
  return best;
}

// Two scans of one room, at poses that are off by a few centimetres, with their matches.
struct Pair {
  std::vector<WallPoint> scan, target;
  Rigid2 scan_pose, target_pose;
  std::vector<std::pair<std::size_t, std::size_t>> matches;

  Pair(std::uint64_t seed, double gate_m) {
    Random random(seed);
    const Rigid2 true_scan = RandomPose(random, 0.8, 3), true_target = RandomPose(random, 0.8, 3);
    scan = WallsFrom(true_scan, 0.01);
    target = WallsFrom(true_target, 0.01);
    const Rigid2 graph_from_room = RandomPose(random, 5, 3);
    scan_pose = graph_from_room * true_scan * RandomPose(random, 0.05, 0.02);
    target_pose = graph_from_room * true_target * RandomPose(random, 0.05, 0.02);
    for (std::size_t i = 0; i < scan.size(); ++i) {
      const auto match = MatchOf(scan[i], target_pose.Inverse() * scan_pose, target, gate_m);
      if (match) matches.emplace_back(i, *match);
    }
  }

  // Residuals of the matches with both poses moved.
  Eigen::VectorXd Residuals(const Vector6& step) const {
    const Rigid2 target_from_scan =
        Added(target_pose, step.tail<3>()).Inverse() * Added(scan_pose, step.head<3>());
    Eigen::VectorXd residuals(static_cast<Eigen::Index>(matches.size()));
    for (std::size_t i = 0; i < matches.size(); ++i) {
      const WallPoint& wall = target[matches[i].second];
      const Eigen::Vector2d at = target_from_scan * scan[matches[i].first].point_in_robot;
      residuals[static_cast<Eigen::Index>(i)] =
          wall.normal_in_robot.dot(at - wall.point_in_robot) / kSigma_m;
    }
    return residuals;
  }
  // Cauchy's, of unit width.
  double Cost(const Vector6& step) const {
    return 0.5 * (1 + Residuals(step).array().square()).log().sum();
  }
};

TEST(CompareScans, TheEquationsAreTheDerivativesOfTheCost) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE(seed);
    const Pair pair(seed, 0.3);
    const PairEquations found =
        CompareScans(pair.scan, pair.scan_pose, pair.target, pair.target_pose, 0.3, kSigma_m);
    ASSERT_GT(pair.matches.size(), 50U);
    ASSERT_EQ(found.num_matches, pair.matches.size());
    Vector6 gradient;
    Eigen::MatrixXd jacobian(static_cast<Eigen::Index>(pair.matches.size()), 6);
    for (int i = 0; i < 6; ++i) {
      const Vector6 step = kStep * Vector6::Unit(i);
      gradient[i] = (pair.Cost(step) - pair.Cost(-step)) / (2 * kStep);
      jacobian.col(i) = (pair.Residuals(step) - pair.Residuals(-step)) / (2 * kStep);
    }
    const Eigen::VectorXd residuals = pair.Residuals(Vector6::Zero());
    const Eigen::VectorXd weights = (1 + residuals.array().square()).inverse();
    const Matrix6 hessian = jacobian.transpose() * weights.asDiagonal() * jacobian;
    EXPECT_LT((found.gradient - gradient).norm(), 1e-5 * gradient.norm());
    EXPECT_LT((found.hessian - hessian).norm(), 1e-6 * hessian.norm());
    EXPECT_NEAR(found.sum_squares_m2, residuals.squaredNorm() * kSigma_m * kSigma_m, 1e-9);
  }
}

TEST(CompareScans, AtTheTruthNothingIsLeft) {
  Random random(1);
  for (int i = 0; i < 10; ++i) {
    const Rigid2 a = RandomPose(random, 0.8, 3), b = RandomPose(random, 0.8, 3);
    const PairEquations found = CompareScans(WallsFrom(a), a, WallsFrom(b), b, 0.1, kSigma_m);
    EXPECT_GT(found.num_matches, 50U);
    EXPECT_LT(std::sqrt(found.sum_squares_m2 / static_cast<double>(found.num_matches)), 2e-3);
  }
  // The same scan twice: exactly.
  const Rigid2 pose{0.4, {0.3, 0.2}};
  const auto walls = WallsFrom(pose);
  const PairEquations same = CompareScans(walls, pose, walls, pose, 0.1, kSigma_m);
  EXPECT_EQ(same.num_matches, walls.size());
  EXPECT_LT(same.sum_squares_m2, 1e-20);
  EXPECT_LT(same.gradient.norm(), 1e-6);
}

// Moving both together changes nothing; without a kernel's help no wall tells where the pair is.
TEST(CompareScans, OnlyTheRelativePoseCounts) {
  const Pair pair(3, 0.3);
  const PairEquations found =
      CompareScans(pair.scan, pair.scan_pose, pair.target, pair.target_pose, 0.3, kSigma_m);
  for (const Eigen::Vector2d& move : {Eigen::Vector2d(1, 0), Eigen::Vector2d(0, 1)}) {
    Vector6 together = Vector6::Zero();
    together.segment<2>(0) = move;
    together.segment<2>(3) = move;
    EXPECT_LT((found.hessian * together).norm(), 1e-9 * found.hessian.norm());
    EXPECT_LT(std::abs(found.gradient.dot(together)), 1e-9 * found.hessian.norm());
  }
  Vector6 turn;  // about the graph's origin
  turn << -pair.scan_pose.translation.y(), pair.scan_pose.translation.x(), 1,
      -pair.target_pose.translation.y(), pair.target_pose.translation.x(), 1;
  EXPECT_LT((found.hessian * turn).norm(), 1e-9 * found.hessian.norm());
}

TEST(CompareScans, ADistantWallOrTheOtherSideOfAPartitionMatchesNothing) {
  std::vector<WallPoint> wall, back;
  for (int i = 0; i < 20; ++i) {
    wall.push_back({{2, 0.05 * i}, {-1, 0}});
    back.push_back({{2, 0.05 * i}, {1, 0}});
  }
  EXPECT_EQ(CompareScans(wall, {}, wall, {0, {0.08, 0}}, 0.1, kSigma_m).num_matches, 20U);
  EXPECT_EQ(CompareScans(wall, {}, wall, {0, {0.12, 0}}, 0.1, kSigma_m).num_matches, 0U);
  EXPECT_EQ(CompareScans(wall, {}, back, {}, 0.1, kSigma_m).num_matches, 0U);
  for (const PairEquations& none : {CompareScans({}, {}, wall, {}, 0.1, kSigma_m),
                                    CompareScans(wall, {}, {}, {}, 0.1, kSigma_m)}) {
    EXPECT_EQ(none.num_matches, 0U);
    EXPECT_EQ(none.hessian, Matrix6::Zero());
    EXPECT_EQ(none.gradient, Vector6::Zero());
  }
}

}  // namespace nightmap::compare_scans_test
