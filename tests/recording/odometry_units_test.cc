// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/odometry_units.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "pipeline/base/random.h"

namespace nightmap::odometry_units_test {

constexpr double kRadInDeg = 180 / std::numbers::pi;

struct Drive {
  double heading_rad = 0;    // of the first lane
  double legs_turn_rad = 0;  // after each of ten lanes of 2 m
  double forward = 1;        // -1: the robot drives backward
  bool wraps = false;        // headings are within a turn
  double side_rad = 0;       // of the wheels' frame against the way
};

// A robot drives 0.1 m per 0.2 s and turns 0.1 rad per 0.2 s.
std::vector<SignalSample> Poses(const Drive& drive, double unit, double headings_unit) {
  std::vector<SignalSample> poses;
  Random random(1, 0);
  double x = 0, y = 0, heading_rad = drive.heading_rad;
  const auto add = [&] {
    double shown_rad = heading_rad + drive.side_rad + 0.01 * random.Gaussian();
    if (drive.wraps) shown_rad = std::remainder(shown_rad, 2 * std::numbers::pi);
    const auto time_ns = static_cast<std::int64_t>(poses.size()) * 200'000'000;
    poses.push_back({time_ns, {unit * x, unit * y, headings_unit * shown_rad}, {}});
  };
  for (int leg = 0; leg < 10; ++leg) {
    for (int i = 0; i < 20; ++i) {
      x += 0.1 * drive.forward * std::cos(heading_rad);
      y += 0.1 * drive.forward * std::sin(heading_rad);
      add();
    }
    const int num_turns = static_cast<int>(std::ceil(std::abs(drive.legs_turn_rad) / 0.1));
    for (int i = 0; i < num_turns; ++i) {
      heading_rad += drive.legs_turn_rad / num_turns;
      add();
    }
  }
  return poses;
}

constexpr double kPi = std::numbers::pi;
// Lanes there and back, squares, rooms at odd angles, straight on, backward, across.
const Drive kDrives[] = {{0, kPi},
                         {0.3, kPi, 1, true},
                         {0, kPi / 2},
                         {1, kPi / 2, 1, true},
                         {0.2, 0.7},
                         {0.2, 2.1, -1, true},
                         {0, -kPi / 2, -1},
                         {0, 1.2, 1, true, 1.57}};

TEST(OdometryUnitsTest, DegreesLookLikeDegrees) {
  for (const Drive& drive : kDrives) {
    EXPECT_TRUE(LookLikeDegrees(Poses(drive, 1, kRadInDeg))) << drive.legs_turn_rad;
    EXPECT_FALSE(LookLikeDegrees(Poses(drive, 1, 1))) << drive.legs_turn_rad;
  }
  const Drive straight{0.5, 0};
  EXPECT_FALSE(LookLikeDegrees(Poses(straight, 1, 1)));
  EXPECT_FALSE(LookLikeDegrees({}));
}

// A robot that counts its turns.
TEST(OdometryUnitsTest, ManyTurnsAreNoDegrees) {
  auto poses = Poses({0, kPi / 2}, 1, 1);
  for (SignalSample& pose : poses) pose.value.z() += 200 * kPi;
  EXPECT_FALSE(LookLikeDegrees(poses));
}

TEST(OdometryUnitsTest, SumsOfChangesInDegrees) {
  EXPECT_TRUE(SumsLookLikeDegrees(Poses({0, kPi / 2}, 1, kRadInDeg)));
  EXPECT_FALSE(SumsLookLikeDegrees(Poses({0, kPi / 2}, 1, 1)));
}

TEST(OdometryUnitsTest, TheUsualSpeed) {
  EXPECT_NEAR(UsualSpeed_m_per_s(Poses({0, kPi / 2}, 1, 1)), 0.5, 0.1);
  EXPECT_NEAR(UsualSpeed_m_per_s(Poses({0, kPi / 2}, 1000, 1)), 500, 100);
  auto jumps = Poses({0, kPi / 2}, 1, 1);
  for (std::size_t i = 100; i < jumps.size(); ++i) jumps[i].value.x() += 1e5;
  EXPECT_NEAR(UsualSpeed_m_per_s(jumps), 0.5, 0.1);
  EXPECT_EQ(UsualSpeed_m_per_s({}), 0);
}

}  // namespace nightmap::odometry_units_test
