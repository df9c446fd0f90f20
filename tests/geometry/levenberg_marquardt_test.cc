// SPDX-License-Identifier: Apache-2.0
#include "pipeline/geometry/levenberg_marquardt.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "pipeline/base/random.h"

namespace nightmap::levenberg_marquardt_test {

using Equations2 = NormalEquations<2>;
using Vector2 = Equations2::Vector;

Vector2 Add(const Vector2& step, const Vector2& at) { return at + step; }

// y = a exp(b x), with one gross outlier if wanted.
struct Curve {
  std::vector<Vector2> samples;

  explicit Curve(bool has_outlier) {
    for (int i = 0; i < 20; ++i) samples.emplace_back(0.1 * i, 2 * std::exp(0.5 * 0.1 * i));
    if (has_outlier) samples[7].y() += 100;
  }

  Equations2 At(const Vector2& ab) const {
    constexpr double kSigma = 0.1;
    Equations2 equations;
    for (const Vector2& sample : samples) {
      const double power = std::exp(ab[1] * sample.x());
      const Eigen::RowVector2d jacobian(power / kSigma, ab[0] * sample.x() * power / kSigma);
      const Eigen::Matrix<double, 1, 1> residual((ab[0] * power - sample.y()) / kSigma);
      equations.AddRobust<1>(jacobian, residual);
    }
    return equations;
  }
};

TEST(MinimizeSmall, FindsTheUnknownsWhateverOneOutlierSays) {
  for (const bool has_outlier : {false, true}) {
    const Curve curve(has_outlier);
    const Vector2 found = MinimizeSmall<2>(
        {.max_steps = 100}, Vector2(1, 0), [&](const Vector2& ab) { return curve.At(ab); }, Add);
    EXPECT_LT((found - Vector2(2, 0.5)).norm(), has_outlier ? 0.01 : 1e-6);
  }
}

TEST(MinimizeSmall, NeverRaisesTheCost) {
  Random random(1);
  const Curve curve(true);
  for (int trial = 0; trial < 50; ++trial) {
    const Vector2 start(random.Uniform(-5, 5), random.Uniform(-3, 3));
    for (int steps = 0; steps < 5; ++steps) {
      const Vector2 found = MinimizeSmall<2>(
          {.max_steps = steps}, start, [&](const Vector2& ab) { return curve.At(ab); }, Add);
      EXPECT_LE(curve.At(found).cost, curve.At(start).cost);
    }
  }
}

TEST(MinimizeSmall, StaysWhereAStepIsNoNumber) {
  const auto nowhere = [](const Vector2&) {
    Equations2 equations;
    equations.gradient.setConstant(std::numeric_limits<double>::quiet_NaN());
    equations.hessian.setIdentity();
    return equations;
  };
  EXPECT_EQ(MinimizeSmall<2>({}, Vector2(3, 4), nowhere, Add), Vector2(3, 4));
}

TEST(NormalEquations, APriorHoldsWhatTheResidualsDoNotTell) {
  Equations2 equations;
  equations.AddRobust<1>(Eigen::RowVector2d(2, 0), Eigen::Matrix<double, 1, 1>(0));
  EXPECT_FALSE(equations.Covariance());
  equations.AddPrior(Vector2(0, 16), Vector2(5, 1));
  ASSERT_TRUE(equations.Covariance());
  EXPECT_NEAR((*equations.Covariance())(0, 0), 1.0 / 4, 1e-12);
  EXPECT_NEAR((*equations.Covariance())(1, 1), 1.0 / 16, 1e-12);
  EXPECT_EQ(equations.cost, 16);
}

}  // namespace nightmap::levenberg_marquardt_test
