// SPDX-License-Identifier: Apache-2.0
#include "pipeline/laser/likelihood_field.h"

#include <algorithm>
#include <cmath>

#include "tests/test_data.h"

namespace nightmap::likelihood_field_test {

const LikelihoodFieldOptions kSmall{.resolution_m = 0.1, .half_extent_m = 2, .sigma_m = 0.2};

TEST(LikelihoodField, IsAGaussianAroundTheNearestPoint) {
  LikelihoodField field(kSmall);
  const std::vector<Eigen::Vector2d> points = {{0.33, -0.71}, {1.2, 1.1}};
  field.Add(points);
  for (int row = 0; row < field.Size(); ++row) {
    for (int column = 0; column < field.Size(); ++column) {
      const Eigen::Vector2d center = 0.1 * Eigen::Vector2d(column - 19.5, row - 19.5);
      const double distance_m = std::min((center - points[0]).norm(), (center - points[1]).norm());
      const double expected = distance_m <= 0.6 ? std::exp(-distance_m * distance_m / 0.08) : 0.0;
      ASSERT_NEAR(field.At(column, row), expected, 0.012) << column << " " << row;
    }
  }
}

TEST(LikelihoodField, PointsOutsideAndTheirOrderDoNotMatter) {
  LikelihoodField a(kSmall), b(kSmall);
  a.Add({{0, 0}, {1.9, -1.9}, {50, 0}, {-1e300, 3}});
  b.Add({{1.9, -1.9}});
  b.Add({{0, 0}});
  for (int i = -3; i < a.Size() + 3; ++i) {
    for (int j = -3; j < a.Size() + 3; ++j) ASSERT_EQ(a.At(i, j), b.At(i, j));
  }
  EXPECT_EQ(a.At(-1, 0), 0);
  EXPECT_EQ(a.At(0, a.Size()), 0);
}

}  // namespace nightmap::likelihood_field_test
