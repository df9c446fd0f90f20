// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_adjust/keyscan_system.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"

namespace nightmap::keyscan_system_test {

using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;

TEST(KeyscanSystem, StepSolvesTheSameEquationsWrittenOutInFull) {
  const Pairs pairs{{0, 1}, {2, 1}, {1, 2}, {3, 0}, {2, 3}, {0, 3}};
  KeyscanSystem system(4, pairs);
  Random random(1);
  for (int round = 0; round < 2; ++round) {  // a round leaves nothing to the next one
    system.Clear();
    Eigen::MatrixXd full = Eigen::MatrixXd::Zero(12, 12);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(12);
    full.topLeftCorner<3, 3>().diagonal().setConstant(1e12);
    for (const auto& [a, b] : pairs) {
      Matrix6 root;
      for (double& value : root.reshaped()) value = random.Gaussian();
      const Matrix6 hessian = root * root.transpose();
      const Vector6 slope = root.col(0);
      system.Add(a, b, hessian, slope);
      const std::size_t first[] = {3 * a, 3 * b};
      for (std::size_t i = 0; i < 6; ++i) {
        const auto row = static_cast<Eigen::Index>(first[i / 3] + i % 3);
        gradient[row] += slope[static_cast<Eigen::Index>(i)];
        for (std::size_t j = 0; j < 6; ++j) {
          full(row, static_cast<Eigen::Index>(first[j / 3] + j % 3)) +=
              hessian(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
        }
      }
    }
    const Eigen::VectorXd expected = -full.ldlt().solve(gradient);
    const Eigen::VectorXd step = system.Step();
    EXPECT_LT((step - expected).norm(), 1e-9 * expected.norm());
    EXPECT_GT(step.norm(), 1e-3);
  }
}

TEST(KeyscanSystem, EquationsWithoutASolutionAreRefused) {
  KeyscanSystem system(2, {{0, 1}});
  EXPECT_THROW(system.Step(), DataError);  // nothing holds the second one
}

}  // namespace nightmap::keyscan_system_test
