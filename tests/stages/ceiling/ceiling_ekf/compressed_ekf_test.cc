// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_ekf/compressed_ekf.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "tests/test_data.h"

namespace nightmap::compressed_ekf_test {

using Sparse = Eigen::SparseMatrix<double, Eigen::RowMajor>;

Eigen::MatrixXd RandomMatrix(Eigen::Index rows, Eigen::Index cols, Random* random) {
  Eigen::MatrixXd matrix(rows, cols);
  for (Eigen::Index i = 0; i < rows; ++i) {
    for (Eigen::Index j = 0; j < cols; ++j) matrix(i, j) = random->Gaussian();
  }
  return matrix;
}

Eigen::MatrixXd RandomCovariance(Eigen::Index size, Random* random) {
  const Eigen::MatrixXd root = RandomMatrix(size, size, random);
  return root * root.transpose() + Eigen::MatrixXd::Identity(size, size);
}

double SmallestEigenvalue(const Eigen::MatrixXd& matrix) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix).eigenvalues().minCoeff();
}

// The textbook's filter, with the inverse that nobody should take.
struct PlainFilter {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;

  void Transform(const Eigen::MatrixXd& jacobian, const Eigen::MatrixXd& noise) {
    mean = (jacobian * mean).eval();
    covariance = jacobian * covariance * jacobian.transpose() + noise;
  }
  double Update(const Eigen::MatrixXd& rows,
                const Eigen::VectorXd& residual,
                const Eigen::VectorXd& variance) {
    const Eigen::MatrixXd innovation =
        rows * covariance * rows.transpose() + Eigen::MatrixXd(variance.asDiagonal());
    const Eigen::MatrixXd gain = covariance * rows.transpose() * innovation.inverse();
    mean += gain * residual;
    covariance = (covariance - gain * innovation * gain.transpose()).eval();
    return residual.dot(innovation.inverse() * residual);
  }
};

TEST(CompressedEkf, IsTheKalmanFilterInTheLinearGaussianCase) {
  Random random(1, 0, 0);
  const Eigen::Index n = 6;
  PlainFilter plain{RandomMatrix(n, 1, &random), RandomCovariance(n, &random)};
  CompressedEkf filter(plain.mean, plain.covariance);
  for (int step = 0; step < 50; ++step) {
    const Eigen::MatrixXd motion =
        Eigen::MatrixXd::Identity(n, n) + 0.1 * RandomMatrix(n, n, &random);
    const Eigen::MatrixXd noise = 0.1 * RandomCovariance(n, &random);
    plain.Transform(motion, noise);
    filter.Transform(plain.mean, Sparse(motion.sparseView()), Sparse(noise.sparseView()));
    const Eigen::MatrixXd rows = RandomMatrix(3, n, &random);
    const Eigen::VectorXd measured = RandomMatrix(3, 1, &random);
    const Eigen::VectorXd variance = Eigen::VectorXd::Constant(3, 0.5);
    const Eigen::VectorXd residual = measured - rows * plain.mean;
    const Measurement measurement{Sparse(rows.sparseView()), residual, variance};
    const double tested = filter.Test(measurement, 3)[0];
    const double squared = plain.Update(rows, residual, variance);
    const Innovation innovation = filter.Update(measurement);
    EXPECT_NEAR(innovation.squared, squared, 1e-8 * (1 + squared));
    EXPECT_NEAR(tested, squared, 1e-8 * (1 + squared));
    EXPECT_EQ(innovation.degrees_of_freedom, 3);
    ASSERT_LT((filter.Active() - plain.mean).norm(), 1e-9 * plain.mean.norm());
    ASSERT_LT((filter.ActiveCovariance() - plain.covariance).norm(),
              1e-9 * plain.covariance.norm());
  }
}

// Active states come, move, are measured and are kept; the plain filter holds all of them.
TEST(CompressedEkf, GivesWhatTheWholeFilterGives) {
  Random random(2, 0, 0);
  Eigen::Index n = 5;
  PlainFilter plain{RandomMatrix(n, 1, &random), RandomCovariance(n, &random)};
  CompressedEkf filter(plain.mean, plain.covariance);
  for (int round = 0; round < 20; ++round) {
    const Eigen::Index kept = filter.NumKept();
    // The plain filter's state is the active one, then the kept one.
    for (int step = 0; step < 2; ++step) {
      // One state more, a function of the others; another moves.
      Eigen::MatrixXd motion = Eigen::MatrixXd::Identity(n + 1, n);
      motion.row(n) = RandomMatrix(1, n, &random);
      motion.row(0) += 0.1 * RandomMatrix(1, n, &random);
      const Eigen::MatrixXd noise = 0.1 * RandomCovariance(n + 1, &random);
      Eigen::MatrixXd whole = Eigen::MatrixXd::Zero(n + 1 + kept, n + kept);
      whole.topLeftCorner(n + 1, n) = motion;
      whole.bottomRightCorner(kept, kept).setIdentity();
      Eigen::MatrixXd whole_noise = Eigen::MatrixXd::Zero(n + 1 + kept, n + 1 + kept);
      whole_noise.topLeftCorner(n + 1, n + 1) = noise;
      plain.Transform(whole, whole_noise);
      ++n;
      filter.Transform(plain.mean.head(n), Sparse(motion.sparseView()), Sparse(noise.sparseView()));
      const Eigen::MatrixXd rows = RandomMatrix(2, n, &random);
      Eigen::MatrixXd whole_rows = Eigen::MatrixXd::Zero(2, n + kept);
      whole_rows.leftCols(n) = rows;
      const Eigen::VectorXd residual = RandomMatrix(2, 1, &random);
      const Eigen::VectorXd variance = Eigen::VectorXd::Constant(2, 0.3);
      plain.Update(whole_rows, residual, variance);
      filter.Update({Sparse(rows.sparseView()), residual, variance});
    }
    // A loop: both parts are measured.
    const Eigen::MatrixXd rows = RandomMatrix(3, n + kept, &random);
    const Eigen::VectorXd residual = RandomMatrix(3, 1, &random);
    const Eigen::VectorXd variance = Eigen::VectorXd::Constant(3, 0.3);
    const double squared = plain.Update(rows, residual, variance);
    const Innovation innovation =
        filter.Update({Sparse(rows.leftCols(n).sparseView()), residual, variance},
                      Sparse(rows.rightCols(kept).sparseView()));
    EXPECT_NEAR(innovation.squared, squared, 1e-6 * (1 + squared));
    // Two states of the middle are kept.
    const Eigen::Index first = 1;
    filter.Keep(first, 2);
    Eigen::VectorXi order(n + kept);
    Eigen::Index place = 0;
    for (Eigen::Index i = 0; i < n + kept; ++i) {
      if (i < first || i >= first + 2) order[place++] = static_cast<int>(i);
    }
    order[place] = static_cast<int>(first);
    order[place + 1] = static_cast<int>(first) + 1;
    plain.mean = plain.mean(order).eval();
    plain.covariance = plain.covariance(order, order).eval();
    n -= 2;
  }
  const Eigen::Index kept = filter.NumKept();
  ASSERT_EQ(kept, 40);  // so much more than is active that steps are deferred
  const double scale = plain.covariance.norm();
  EXPECT_LT((filter.Active() - plain.mean.head(n)).norm(), 1e-8 * plain.mean.norm());
  EXPECT_LT((filter.Kept() - plain.mean.tail(kept)).norm(), 1e-8 * plain.mean.norm());
  EXPECT_LT((filter.ActiveCovariance() - plain.covariance.topLeftCorner(n, n)).norm(),
            1e-8 * scale);
  EXPECT_LT(
      (filter.KeptCovariance(0, kept) - plain.covariance.bottomRightCorner(kept, kept)).norm(),
      1e-8 * scale);
  EXPECT_LT((filter.CrossCovariance() - plain.covariance.topRightCorner(n, kept)).norm(),
            1e-8 * scale);
}

// The considered state keeps mean and variance; the others are worse known than if it were told.
TEST(CompressedEkf, AConsideredStateIsNotEstimated) {
  Random random(7, 0, 0);
  const Eigen::Index n = 4;
  const Eigen::MatrixXd covariance = RandomCovariance(n, &random);
  const Eigen::VectorXd mean = RandomMatrix(n, 1, &random);
  CompressedEkf considering(mean, covariance, 1), estimating(mean, covariance);
  const Eigen::MatrixXd rows = RandomMatrix(2, n, &random);
  const Measurement measurement{
      Sparse(rows.sparseView()), RandomMatrix(2, 1, &random), Eigen::VectorXd::Constant(2, 0.3)};
  considering.Update(measurement);
  estimating.Update(measurement);
  EXPECT_EQ(considering.Active()[1], mean[1]);
  EXPECT_EQ(considering.ActiveCovariance()(1, 1), covariance(1, 1));
  EXPECT_NE(estimating.Active()[1], mean[1]);
  EXPECT_EQ(considering.Active()[0], estimating.Active()[0]);
  EXPECT_GT(SmallestEigenvalue(considering.ActiveCovariance()), 0);
  // Again: what it does to the others is not forgotten, so they do not get as sure.
  for (int i = 0; i < 50; ++i) {
    considering.Update(measurement);
    estimating.Update(measurement);
  }
  const Eigen::MatrixXd more = considering.ActiveCovariance() - estimating.ActiveCovariance();
  EXPECT_GT(more.trace(), 0.1);
  EXPECT_GT(SmallestEigenvalue(considering.ActiveCovariance()), 0);
}

TEST(CompressedEkf, CovarianceStaysSymmetricAndPositiveDefinite) {
  Random random(3, 0, 0);
  const Eigen::Index n = 8;
  CompressedEkf filter(Eigen::VectorXd::Zero(n), RandomCovariance(n, &random));
  const Eigen::MatrixXd copy = Eigen::MatrixXd::Identity(n, n);
  const Eigen::VectorXd variance = Eigen::VectorXd::Constant(2, 1e-6);
  Eigen::MatrixXd noise = Eigen::MatrixXd::Zero(n, n);
  noise(0, 0) = 1e-4;  // all but one state stand still, and are measured ever better
  for (int step = 0; step < 10'000; ++step) {
    filter.Transform(filter.Active(), Sparse(copy.sparseView()), Sparse(noise.sparseView()));
    const Eigen::MatrixXd rows = RandomMatrix(2, n, &random);
    const Eigen::VectorXd residual = 1e-3 * RandomMatrix(2, 1, &random);
    filter.Update({Sparse(rows.sparseView()), residual, variance});
    if (step % 500 != 0) continue;
    ASSERT_EQ(filter.ActiveCovariance(), filter.ActiveCovariance().transpose());
    ASSERT_GT(SmallestEigenvalue(filter.ActiveCovariance()), 0) << step;
  }
}

TEST(CompressedEkf, RefusesWhatIsNoMeasurement) {
  CompressedEkf filter(Eigen::VectorXd::Zero(2), Eigen::MatrixXd::Identity(2, 2));
  const Sparse rows(Eigen::MatrixXd::Identity(2, 2).sparseView());
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(2);
  EXPECT_THROW(filter.Update({rows, zero, Eigen::VectorXd::Constant(2, -2)}), DataError);
  EXPECT_THROW(filter.Update({rows, zero, Eigen::VectorXd::Constant(2, NAN)}), DataError);
  EXPECT_THROW(filter.Update({rows, Eigen::VectorXd::Constant(2, NAN), Eigen::VectorXd::Ones(2)}),
               DataError);
}

}  // namespace nightmap::compressed_ekf_test
