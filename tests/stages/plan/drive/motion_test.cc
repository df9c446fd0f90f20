// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/drive/motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "pipeline/base/random.h"

namespace nightmap::motion_test {

PlanarPose DrawPose(Random& random) {
  return {{random.Uniform(-5, 5), random.Uniform(-5, 5)}, random.Uniform(-3, 3)};
}

MotionLimits DrawLimits(Random& random) {
  MotionLimits limits;
  limits.max_v_m_s = random.Uniform(0.1, 2);
  limits.max_omega_rad_s = random.Uniform(0.1, 3);
  limits.max_acceleration_m_s2 = random.Uniform(0.1, 3);
  limits.max_angular_acceleration_rad_s2 = random.Uniform(0.1, 5);
  limits.period_s = random.Uniform(0.005, 0.2);
  return limits;
}

TEST(Motion, ArcIsTheLimitOfSmallStraightSteps) {
  Random random(1);
  for (int i = 0; i < 50; ++i) {
    const PlanarPose start = DrawPose(random);
    const Twist twist{random.Uniform(-1, 1), i % 5 == 0 ? 1e-8 : random.Uniform(-3, 3)};
    const double duration_s = random.Uniform(0, 2);
    constexpr int kNumSteps = 20000;
    PlanarPose stepped = start;
    for (int k = 0; k < kNumSteps; ++k) {
      const double heading_rad =
          start.heading_rad + twist.omega_rad_s * duration_s * (k + 0.5) / kNumSteps;
      stepped.point_in_map += twist.v_m_s * duration_s / kNumSteps *
                              Eigen::Vector2d(std::cos(heading_rad), std::sin(heading_rad));
    }
    const PlanarPose end = Advance(start, twist, duration_s);
    EXPECT_LT((end.point_in_map - stepped.point_in_map).norm(), 1e-8);
    const double turned_rad = end.heading_rad - start.heading_rad - twist.omega_rad_s * duration_s;
    EXPECT_NEAR(WrapAngle(turned_rad), 0, 1e-12);
  }
}

TEST(Motion, TwoHalvesAreTheWhole) {
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const PlanarPose start = DrawPose(random);
    const Twist twist{random.Uniform(-1, 1), random.Uniform(-3, 3) * (i % 3)};
    const PlanarPose whole = Advance(start, twist, 0.8);
    const PlanarPose halves = Advance(Advance(start, twist, 0.3), twist, 0.5);
    EXPECT_LT((whole.point_in_map - halves.point_in_map).norm(), 1e-12);
    EXPECT_NEAR(WrapAngle(whole.heading_rad - halves.heading_rad), 0, 1e-12);
  }
}

TEST(Motion, AnglesWrapToTheHalfOpenTurn) {
  constexpr double kPi = std::numbers::pi;
  EXPECT_EQ(WrapAngle(0.5), 0.5);
  EXPECT_EQ(WrapAngle(-kPi), kPi);
  EXPECT_NEAR(WrapAngle(3 * kPi), kPi, 1e-12);
  EXPECT_NEAR(WrapAngle(2 * kPi + 0.1), 0.1, 1e-12);
  EXPECT_NEAR(WrapAngle(-7 * kPi - 0.1), kPi - 0.1, 1e-12);
}

TEST(Motion, ReachedTwistsAreWholeMillionthsWithinTheLimits) {
  Random random(3);
  for (int i = 0; i < 100; ++i) {
    const MotionLimits limits = DrawLimits(random);
    const double max_change_m_s = limits.max_acceleration_m_s2 * limits.period_s;
    const double max_change_rad_s = limits.max_angular_acceleration_rad_s2 * limits.period_s;
    Twist twist;
    for (int k = 0; k < 50; ++k) {
      const Twist wish{random.Uniform(-4, 4), random.Uniform(-4, 4)};
      const Twist next = Reach(twist, wish, limits);
      EXPECT_LE(std::abs(next.v_m_s), limits.max_v_m_s + 1e-12);
      EXPECT_LE(std::abs(next.omega_rad_s), limits.max_omega_rad_s + 1e-12);
      EXPECT_LE(std::abs(next.v_m_s - twist.v_m_s), max_change_m_s + 1e-12);
      EXPECT_LE(std::abs(next.omega_rad_s - twist.omega_rad_s), max_change_rad_s + 1e-12);
      EXPECT_NEAR(next.v_m_s * 1e6, std::round(next.v_m_s * 1e6), 1e-6);
      EXPECT_NEAR(next.omega_rad_s * 1e6, std::round(next.omega_rad_s * 1e6), 1e-6);
      const bool is_near = std::abs(wish.v_m_s - twist.v_m_s) < max_change_m_s - 1e-6;
      if (is_near && std::abs(wish.v_m_s) < limits.max_v_m_s - 1e-6) {
        EXPECT_NEAR(next.v_m_s, wish.v_m_s, 1e-6);
      }
      twist = next;
    }
  }
}

TEST(Motion, BrakingEndsAtRestWithinTheLimits) {
  Random random(4);
  for (int i = 0; i < 200; ++i) {
    const MotionLimits limits = DrawLimits(random);
    const Twist fast{random.Uniform(0, limits.max_v_m_s),
                     random.Uniform(-1, 1) * limits.max_omega_rad_s};
    Twist twist = Reach(fast, fast, limits);
    const double least_s =
        std::max(twist.v_m_s / limits.max_acceleration_m_s2,
                 std::abs(twist.omega_rad_s) / limits.max_angular_acceleration_rad_s2);
    // First the speed, then what is left of the turn; two periods for what is no whole step.
    const double most_s = twist.v_m_s / limits.max_acceleration_m_s2 +
                          std::abs(twist.omega_rad_s) / limits.max_angular_acceleration_rad_s2;
    double duration_s = 0;
    while (!twist.IsRest() && duration_s < 2 * most_s + 1) {
      const Twist next = Brake(twist, limits);
      EXPECT_GE(next.v_m_s, 0);
      EXPECT_LE(next.v_m_s, twist.v_m_s);
      EXPECT_LE(std::abs(next.omega_rad_s), std::abs(twist.omega_rad_s));
      EXPECT_LE(std::abs(next.omega_rad_s - twist.omega_rad_s),
                limits.max_angular_acceleration_rad_s2 * limits.period_s + 1e-12);
      twist = next;
      duration_s += limits.period_s;
    }
    EXPECT_TRUE(twist.IsRest());
    EXPECT_GE(duration_s, least_s - 1e-9);
    EXPECT_LE(duration_s, 1.01 * most_s + 2 * limits.period_s);
  }
}

// Driving at that speed in every period stops at the place itself, never past it, and never needs
// more than the deceleration.
TEST(Motion, SpeedToStopWithinStopsThere) {
  Random random(5);
  for (int i = 0; i < 500; ++i) {
    const double acceleration = random.Uniform(0.1, 3);
    const double period_s = random.Uniform(0.005, 0.2);
    double left = random.Uniform(0, 3);
    double speed = SpeedToStopWithin(left, acceleration, period_s);
    int num_periods = 0;
    while (left > 1e-9 && num_periods < 10000) {
      left -= speed * period_s;
      EXPECT_GE(left, -1e-9);
      const double next = SpeedToStopWithin(left, acceleration, period_s);
      EXPECT_GE(next, speed - acceleration * period_s - 1e-9);
      speed = next;
      ++num_periods;
    }
    EXPECT_LT(num_periods, 10000);
  }
  EXPECT_EQ(SpeedToStopWithin(-1, 1, 0.1), 0);
}

}  // namespace nightmap::motion_test
