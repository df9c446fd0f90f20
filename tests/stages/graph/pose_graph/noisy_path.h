// SPDX-License-Identifier: Apache-2.0
// Odometry along a path of equal steps, with noise of known covariance.
#pragma once

#include <vector>

#include "pipeline/base/random.h"
#include "pipeline/io/odometry_io.h"

namespace nightmap {

inline Matrix6d StepCovariance() {
  constexpr double kSigma_rad = 0.004;
  constexpr double kSigma_m = 0.01;
  Matrix6d covariance = Matrix6d::Zero();
  covariance.diagonal() << Eigen::Vector3d::Constant(kSigma_rad * kSigma_rad),
      Eigen::Vector3d::Constant(kSigma_m * kSigma_m);
  return covariance;
}

inline Rigid3 Step() {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(0.05, Eigen::Vector3d(0.2, 1, 0.1).normalized())),
          {0.3, 0.02, 0.1}};
}

// A left perturbation drawn from StepCovariance().
inline Rigid3 DrawNoise(Random& random) {
  Eigen::Matrix<double, 6, 1> x;
  for (double& value : x) value = random.Gaussian();
  x.array() *= StepCovariance().diagonal().array().sqrt();
  const Eigen::Vector3d turn = x.head<3>();
  return {Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized())), x.tail<3>()};
}

// Edges between frames i and i + 1.
inline std::vector<PoseEdge> Drive(int num_frames, std::uint64_t seed) {
  Random random(seed);
  std::vector<PoseEdge> edges;
  for (int i = 1; i < num_frames; ++i) {
    edges.push_back({i - 1, i, DrawNoise(random) * Step().Inverse(), StepCovariance(), false});
  }
  return edges;
}

// An exact loop between two frames of the path without noise.
inline PoseEdge TrueLoop(int a, int b) {
  Rigid3 b_from_a;
  for (int i = a; i < b; ++i) b_from_a = Step().Inverse() * b_from_a;
  return {a, b, b_from_a, 1e-10 * Matrix6d::Identity(), false};
}

}  // namespace nightmap
