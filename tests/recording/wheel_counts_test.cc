// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/wheel_counts.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/base/random.h"

namespace nightmap::wheel_counts_test {

// A wheel that mostly drives one way, from `start` on, in whole ticks.
std::vector<double> Walk(std::uint64_t seed, double start, double step, int count) {
  Random random(seed, 0);
  std::vector<double> counts = {start};
  for (int i = 1; i < count; ++i) {
    counts.push_back(counts.back() + std::round(random.Uniform(-0.3 * step, step)));
  }
  return counts;
}

std::vector<double> Wrapped(std::vector<double> counts, double first, double period) {
  for (double& count : counts) {
    count -= period * std::floor((count - first) / period);
  }
  return counts;
}

TEST(WheelCountsTest, ACounterThatBeganAgainIsCountedOn) {
  for (const int bits : {8, 16, 32}) {
    const double period = std::ldexp(1, bits);
    for (const double first : {0.0, -period / 2}) {
      for (std::uint64_t seed = 0; seed < 20; ++seed) {
        const double forward = seed % 2 ? -1 : 1;
        const auto counts = Walk(seed, std::floor(0.1 * period), forward * 0.09 * period, 300);
        const auto unwrapped = UnwrapCounts(Wrapped(counts, first, period));
        for (std::size_t i = 0; i < counts.size(); ++i) {
          ASSERT_EQ(unwrapped[i] - unwrapped[0], counts[i] - counts[0]) << bits << ' ' << seed;
        }
      }
    }
  }
}

TEST(WheelCountsTest, CountsThatDoNotReachBothEndsStay) {
  EXPECT_TRUE(UnwrapCounts({}).empty());
  for (const double start : {-70.0, 0.0, 300.0, 1e6}) {
    const auto counts = Walk(3, start, 40, 300);
    EXPECT_EQ(UnwrapCounts(counts), counts);
  }
  // A counter that is set back far from its end.
  auto counts = Walk(3, 0, 40, 300);
  for (std::size_t i = 150; i < counts.size(); ++i) counts[i] -= counts[149];
  EXPECT_EQ(UnwrapCounts(counts), counts);
}

}  // namespace nightmap::wheel_counts_test
