// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/sparse_cholesky.h"

#include <Eigen/Dense>
#include <limits>

#include "pipeline/base/random.h"
#include "tests/failing_cholmod.h"
#include "tests/test_data.h"

namespace nightmap::sparse_cholesky_test {

constexpr int kSize = 200;

// Positive definite for shift > 0; for a negative one it is not.
Eigen::SparseMatrix<double> Lower(double shift) {
  Random random(1);
  Eigen::SparseMatrix<double> lower(kSize, kSize);
  for (int column = 0; column < kSize; ++column) {
    lower.insert(column, column) = 2 * kSize * shift;
    for (int row = column + 1; row < kSize; ++row) lower.insert(row, column) = random.Gaussian();
  }
  lower.makeCompressed();
  return lower;
}

TEST(SparseCholesky, SolvesAsADenseFactorDoes) {
  const auto lower = Lower(1);
  SparseCholesky cholesky("use more memory");
  cholesky.Analyze(lower);
  const Eigen::VectorXd right_side = Eigen::VectorXd::LinSpaced(kSize, -1, 1);
  const auto solution = cholesky.Solve(lower, right_side);
  ASSERT_TRUE(solution);
  const Eigen::MatrixXd dense = Eigen::MatrixXd(lower).selfadjointView<Eigen::Lower>();
  EXPECT_LT((dense * *solution - right_side).norm(), 1e-12 * right_side.norm() * kSize);
}

TEST(SparseCholesky, WhatIsNotPositiveDefiniteHasNoSolutionAndTheNextHas) {
  SparseCholesky cholesky("use more memory");
  cholesky.Analyze(Lower(1));
  const Eigen::VectorXd right_side = Eigen::VectorXd::Ones(kSize);
  EXPECT_FALSE(cholesky.Solve(Lower(-1), right_side));
  EXPECT_TRUE(cholesky.Solve(Lower(1), right_side));
}

TEST(SparseCholesky, AFactorThatDoesNotFitIsAnError) {
  const auto lower = Lower(1);
  const Eigen::VectorXd right_side = Eigen::VectorXd::Ones(kSize);
  SparseCholesky cholesky("use more memory");
  cholesky.Analyze(lower);
  {
    const FailingCholmod without_memory(kSize * kSize * sizeof(double) / 2);
    NIGHTMAP_EXPECT_ERROR(DataError, cholesky.Solve(lower, right_side), "does not fit into memory");
  }
  EXPECT_TRUE(cholesky.Solve(lower, right_side)) << "once there is memory again";
}

TEST(SparseCholesky, APatternThatDoesNotFitIsAnError) {
  SparseCholesky cholesky("use more memory");
  const FailingCholmod without_memory(100);
  NIGHTMAP_EXPECT_ERROR(DataError, (cholesky.Analyze(Lower(1)), true), "use more memory");
}

TEST(SparseCholesky, MoreEntriesThanAnIndexCountsAreAnError) {
  constexpr std::size_t kMax = std::numeric_limits<int>::max();
  EXPECT_EQ(SparseIndex(kMax), std::numeric_limits<int>::max());
  NIGHTMAP_EXPECT_ERROR(DataError, SparseIndex(kMax + 1), "2147483648 entries is too large");
}

}  // namespace nightmap::sparse_cholesky_test
