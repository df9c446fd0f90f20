// SPDX-License-Identifier: Apache-2.0
#include "stages/pose_graph/drift_gate.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <numeric>

#include "pipeline/base/random.h"

namespace nightmap {
namespace {

constexpr double kSigma_rad = 0.004;
constexpr double kSigma_m = 0.01;

Matrix6d EdgeCovariance() {
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal() << Eigen::Vector3d::Constant(kSigma_rad * kSigma_rad),
      Eigen::Vector3d::Constant(kSigma_m * kSigma_m);
  return covariance;
}

Rigid3 Step() {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(0.05, Eigen::Vector3d(0.2, 1, 0.1).normalized())),
          {0.3, 0.02, 0.1}};
}

// A perturbation drawn from the edges' covariance.
Rigid3 Noise(Random& random) {
  const Eigen::Vector3d turn =
      kSigma_rad * Eigen::Vector3d(random.Gaussian(), random.Gaussian(), random.Gaussian());
  return {Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized())),
          kSigma_m * Eigen::Vector3d(random.Gaussian(), random.Gaussian(), random.Gaussian())};
}

struct Chain {
  std::vector<GraphEdge> edges;
  std::map<int, Rigid3> world_from_camera;
};

// What odometry with this noise makes of a path of equal steps.
Chain Drive(int num_frames, std::uint64_t seed) {
  Random random(seed);
  Chain chain;
  chain.world_from_camera[0] = Rigid3();
  for (int i = 1; i < num_frames; ++i) {
    const Rigid3 b_from_a = Noise(random) * Step().Inverse();
    chain.world_from_camera[i] = chain.world_from_camera[i - 1] * b_from_a.Inverse();
    chain.edges.push_back({{i - 1, i, b_from_a, EdgeCovariance(), false}});
  }
  return chain;
}

// An exact loop between two frames of the path without noise.
PoseEdge TrueLoop(int a, int b) {
  Rigid3 b_from_a;
  for (int i = a; i < b; ++i) b_from_a = Step().Inverse() * b_from_a;
  return {a, b, b_from_a, 1e-10 * Matrix6d::Identity(), false};
}

TEST(DriftGate, DistanceOfTrueLoopsIsThatOfTheDrift) {
  for (const auto& [a, b] : {std::pair(0, 20), {30, 70}, {5, 99}}) {
    double sum = 0;
    constexpr int kNumTrials = 200;
    for (int trial = 0; trial < kNumTrials; ++trial) {
      const Chain chain = Drive(100, static_cast<std::uint64_t>(trial));
      const double distance =
          DriftGate(chain.edges, chain.world_from_camera).Distance(TrueLoop(a, b));
      sum += distance * distance;
    }
    EXPECT_NEAR(sum / kNumTrials, 6, 0.8) << a << " " << b;  // chi squared, 6 degrees of freedom
  }
}

TEST(DriftGate, IsTheSameFromAnyOrigin) {
  const Chain chain = Drive(60, 1);
  const Rigid3 moved{Eigen::Quaterniond(Eigen::AngleAxisd(2, Eigen::Vector3d::UnitZ())),
                     {9, -7, 3}};
  Chain other = chain;
  for (auto& [idx, pose] : other.world_from_camera) pose = moved * pose;
  PoseEdge loop = TrueLoop(10, 50);
  loop.b_from_a.translation.x() += 0.2;
  EXPECT_NEAR(DriftGate(chain.edges, chain.world_from_camera).Distance(loop),
              DriftGate(other.edges, other.world_from_camera).Distance(loop),
              1e-6);
}

TEST(DriftGate, AWrongPlaceIsFarAndALooseEdgeForgives) {
  Chain chain = Drive(60, 1);
  PoseEdge loop = TrueLoop(10, 50);
  loop.b_from_a.translation.z() += 3;
  EXPECT_GT(DriftGate(chain.edges, chain.world_from_camera).Distance(loop), 10);
  chain.edges[30].edge.covariance = 100 * Matrix6d::Identity();  // a bridge
  EXPECT_LT(DriftGate(chain.edges, chain.world_from_camera).Distance(loop), 3);
}

}  // namespace
}  // namespace nightmap
