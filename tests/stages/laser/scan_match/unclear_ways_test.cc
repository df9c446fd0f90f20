// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_match/unclear_ways.h"

#include <gtest/gtest.h>

#include "pipeline/base/random.h"

namespace nightmap::unclear_ways_test {

constexpr double kRate_hz = 5;
constexpr double kStep_m = 0.1;
constexpr double kWheelsPerMetre = 1.04;

// A drive of straight steps that turn a little; the scans [first, end) are in a bare corridor, in
// which the wheels tell the way.
std::vector<MatchedScan> Drive(int num_scans, int first, int end, double turn_rad = 0.01) {
  std::vector<MatchedScan> scans(static_cast<std::size_t>(num_scans));
  for (int i = 0; i < num_scans; ++i) {
    MatchedScan& scan = scans[static_cast<std::size_t>(i)];
    scan.time_ns = static_cast<std::int64_t>(i * 1e9 / kRate_hz);
    scan.is_matched = true;
    if (i == 0) continue;
    const Rigid2 by_wheels{turn_rad, {kWheelsPerMetre * kStep_m, 0}};
    const bool is_unclear = i >= first && i < end;
    if (is_unclear) scan.unclear_in_robot = Eigen::Vector2d::UnitX();
    scan.last_from_robot_by_wheels = by_wheels;
    const Rigid2 step = is_unclear ? by_wheels : Rigid2{turn_rad, {kStep_m, 0}};
    scan.start_from_robot = scans[static_cast<std::size_t>(i - 1)].start_from_robot * step;
  }
  return scans;
}

TEST(UnclearWays, TheScaleIsThatOfTheWaysThatWallsTell) {
  const auto scale = WheelScale(Drive(200, 60, 140));
  ASSERT_TRUE(scale.has_value());
  EXPECT_NEAR(*scale, 1 / kWheelsPerMetre, 1e-6);
}

TEST(UnclearWays, AScaleIsNotKnownWithoutWallsOrWheels) {
  EXPECT_FALSE(WheelScale(Drive(200, 1, 200)).has_value());
  EXPECT_FALSE(WheelScale(Drive(30, 0, 0)).has_value());
  EXPECT_FALSE(WheelScale({}).has_value());
  auto scans = Drive(200, 0, 0);
  for (MatchedScan& scan : scans) scan.last_from_robot_by_wheels.reset();
  EXPECT_FALSE(WheelScale(scans).has_value());
}

// Wheels that slip at random have no scale.
TEST(UnclearWays, AScaleThatDiffersFromWindowToWindowIsNotKnown) {
  auto scans = Drive(200, 0, 0);
  Random random(2);
  for (MatchedScan& scan : scans) {
    if (scan.last_from_robot_by_wheels) {
      scan.last_from_robot_by_wheels->translation *= random.Uniform(-1, 3);
    }
  }
  EXPECT_FALSE(WheelScale(scans).has_value());
}

TEST(UnclearWays, ScalingPutsAllPosesWhereTheWallsWouldHave) {
  const auto truth = Drive(200, 0, 0, 0);
  auto scans = Drive(200, 60, 140, 0);
  ScaleUnclearWays(1 / kWheelsPerMetre, &scans);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    EXPECT_LT(
        (scans[i].start_from_robot.translation - truth[i].start_from_robot.translation).norm(),
        1e-9);
  }
}

TEST(UnclearWays, AScaleOfOneChangesNothing) {
  const auto before = Drive(100, 20, 60);
  auto scans = before;
  ScaleUnclearWays(1, &scans);
  for (std::size_t i = 0; i < scans.size(); ++i) {
    EXPECT_LT(
        (scans[i].start_from_robot.translation - before[i].start_from_robot.translation).norm(),
        1e-9);
  }
}

// Motion across the unclear direction is as the walls say.
TEST(UnclearWays, ScalingKeepsTheWayAcross) {
  auto scans = Drive(100, 1, 100, 0);
  for (MatchedScan& scan : scans) {
    if (scan.unclear_in_robot) scan.unclear_in_robot = Eigen::Vector2d::UnitY();
  }
  const Rigid2 end = scans.back().start_from_robot;
  ScaleUnclearWays(0.5, &scans);
  EXPECT_LT((scans.back().start_from_robot.translation - end.translation).norm(), 1e-9);
}

}  // namespace nightmap::unclear_ways_test
