// SPDX-License-Identifier: Apache-2.0
#include "pipeline/base/median.h"

#include "pipeline/base/random.h"
#include "tests/test_data.h"

namespace nightmap::median_test {

TEST(Median, HasAsManyValuesBelowAsAbove) {
  Random random(1, 2, 3);
  std::vector<double> values;
  for (int i = 0; i < 101; ++i) values.push_back(random.Uniform());
  const double median = Median(values);
  const auto is_below = [&](double value) { return value < median; };
  EXPECT_EQ(std::ranges::count_if(values, is_below), 50);
  EXPECT_EQ(std::ranges::count(values, median), 1);
}

TEST(Median, OfTwoIsTheUpperAndOfNoneZero) {
  EXPECT_EQ(Median(std::vector<float>{3, 1}), 3);
  EXPECT_EQ(Median(std::vector<double>{}), 0);
  EXPECT_EQ(Median(std::vector<int>{7}), 7);
}

}  // namespace nightmap::median_test
