// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/wheel_motion.h"

#include <gtest/gtest.h>

#include <cmath>

namespace nightmap::wheel_motion_test {

constexpr std::int64_t kStep_ns = 100'000'000;

// A robot that drives an arc at 0.5 m/s and 0.4 rad/s; at `reset`, if any, its driver starts again.
std::vector<SignalSample> Arc(int reset = -1) {
  std::vector<SignalSample> samples;
  for (int i = 0; i < 100; ++i) {
    const double heading_rad = 0.04 * (i < reset || reset < 0 ? i : i - reset);
    samples.push_back(
        {i * kStep_ns,
         {1.25 * std::sin(heading_rad), 1.25 * (1 - std::cos(heading_rad)), heading_rad},
         {}});
  }
  return samples;
}

TEST(WheelMotionTest, AResetIsAGap) {
  for (const int reset : {5, 40, 90}) {
    const auto samples = Arc(reset);
    for (int i = 0; i < 99; ++i) {
      const auto motion = MotionBetween(samples, 0.5, i * kStep_ns, (i + 1) * kStep_ns);
      ASSERT_EQ(motion.has_value(), i + 1 != reset) << reset << ' ' << i;
      if (motion) {
        EXPECT_NEAR(motion->distance_m, 0.05, 1e-9);
      }
    }
    EXPECT_FALSE(MotionBetween(samples, 0.5, (reset - 2) * kStep_ns, (reset + 2) * kStep_ns));
  }
}

// A sample may be stamped late, so that the next one follows at once.
TEST(WheelMotionTest, ALateStepIsNone) {
  auto samples = Arc();
  for (std::size_t i = 40; i < 45; ++i) {
    samples[i].time_ns = 45 * kStep_ns - 5 + static_cast<std::int64_t>(i - 40);
  }
  EXPECT_TRUE(MotionBetween(samples, 1, 0, 99 * kStep_ns));
}

TEST(WheelMotionTest, ARobotMayComeToTheOriginSlowly) {
  const SignalSample origin{kStep_ns, {0, 0, 0}, {}};
  EXPECT_TRUE(IsPossibleStep({0, {0.08, 0, 0.1}, {}}, origin));
  EXPECT_TRUE(IsPossibleStep({0, {0, 0, 0}, {}}, origin));
  EXPECT_FALSE(IsPossibleStep({0, {0.3, 0, 0}, {}}, origin));
  EXPECT_FALSE(IsPossibleStep({0, {0, 0, 0.5}, {}}, origin));
  EXPECT_TRUE(IsPossibleStep({0, {0.3, 0, 0}, {}}, {kStep_ns, {1e-3, 0, 0}, {}}));
  EXPECT_FALSE(IsPossibleStep({0, {9, 0, 0}, {}}, {kStep_ns, {1, 0, 0}, {}}));
}

}  // namespace nightmap::wheel_motion_test
