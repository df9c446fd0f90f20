// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/robot_body.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "pipeline/recording/finish_scans.h"
#include "pipeline/recording/scan_points.h"

namespace nightmap::robot_body_test {

constexpr double kRad = std::numbers::pi / 180;

struct Room {
  double half_x_m = 3;
  double half_y_m = 4;
};

struct Pose {
  double x_m = 0;
  double y_m = 0;
  double heading_rad = 0;
};

// A room without furniture.
double Wall_m(const Room& room, const Pose& pose, double angle_rad) {
  const double x = std::cos(pose.heading_rad + angle_rad);
  const double y = std::sin(pose.heading_rad + angle_rad);
  const double to_x = (std::copysign(room.half_x_m, x) - pose.x_m) / x;
  const double to_y = (std::copysign(room.half_y_m, y) - pose.y_m) / y;
  return std::min(to_x, to_y);
}

std::vector<Pose> DriveAbout() {
  std::vector<Pose> poses;
  for (int i = 0; i < 200; ++i) {
    const double phase = 4 * std::numbers::pi * i / 199;
    poses.push_back({1.5 * std::cos(phase),
                     1.25 * std::sin(2 * phase),
                     std::atan2(2.5 * std::cos(2 * phase), -1.5 * std::sin(phase))});
  }
  return poses;
}

// Scans of a full circle, 2 deg apart, from start_deg on (clockwise if step_deg is below 0). body
// gives the range of the robot in a direction of degrees, -180 to 180; 0: it is not there.
class RobotBodyTest : public testing::Test {
 protected:
  using Body = std::function<double(int angle_deg)>;

  std::vector<SignalSample> Scans(const Body& body, double noise_m = 0.01) {
    std::vector<SignalSample> scans;
    std::normal_distribution<double> noise(0, noise_m);
    for (const Pose& pose : poses_) {
      SignalSample& scan = scans.emplace_back();
      scan.value = {kRad * start_deg_, kRad * step_deg_, 10};
      for (int i = 0; i < 180; ++i) {
        const int angle_deg = start_deg_ + i * step_deg_;
        const double body_m = body((angle_deg + 540) % 360 - 180);
        const double range_m = body_m > 0 ? body_m : Wall_m(room_, pose, kRad * angle_deg);
        scan.ranges_m.push_back(static_cast<float>(range_m + noise(random_)));
      }
    }
    return scans;
  }

  static double Behind(int angle_deg) { return std::abs(angle_deg) >= 136 ? 0.25 : 0; }
  static Body Sector(int first_deg, int last_deg, double range_m) {
    return [=](int angle_deg) {
      return angle_deg >= first_deg && angle_deg <= last_deg ? range_m : 0.0;
    };
  }

  std::vector<Pose> poses_ = DriveAbout();
  Room room_;
  int start_deg_ = -180;
  int step_deg_ = 2;
  std::mt19937 random_{3};
};

TEST_F(RobotBodyTest, WhatStaysIsFoundWithItsRangeAndTheLineToWrite) {
  const auto body = FindRobotBody(Scans(Behind));
  ASSERT_TRUE(body.has_value());
  EXPECT_NEAR(body->share, 45.0 / 180, 1e-9);
  EXPECT_NEAR(body->largest_range_m, 0.25, 0.01);
  EXPECT_EQ(body->sectors_deg, (std::vector{135, 225}));
  EXPECT_EQ(body->remedy, "min_range_m = 0.30");
  EXPECT_TRUE(body->is_certain);
  EXPECT_EQ(FindRobotBody(Scans(Behind, 0.015))->remedy, "min_range_m = 0.35");
}

TEST_F(RobotBodyTest, ASectorIsProposedWhereWallsAreNearerThanTheRobot) {
  for (const auto& [start_deg, step_deg] : {std::pair(-180, 2), {178, -2}, {0, 2}, {358, -2}}) {
    start_deg_ = start_deg;
    step_deg_ = step_deg;
    const auto remedy = [&](const Body& body) { return FindRobotBody(Scans(body, 0.003))->remedy; };
    EXPECT_EQ(remedy(Sector(60, 70, 1.8)), "blind_deg = [59, 71]") << start_deg;
    EXPECT_EQ(remedy(Sector(-20, 20, 1.8)), "blind_deg = [-21, 21]") << start_deg;
    EXPECT_EQ(remedy([](int deg) { return std::abs(deg) >= 136 ? 1.8 : 0; }),
              "blind_deg = [135, 225]")
        << start_deg;
  }
  start_deg_ = -180;
  step_deg_ = 2;
  room_ = {2, 1.7};
  EXPECT_EQ(FindRobotBody(Scans(Sector(-10, 10, 0.8)))->remedy, "blind_deg = [-11, 11]");
}

TEST_F(RobotBodyTest, ARoomAndACorridorAreNotTheRobot) {
  EXPECT_EQ(FindRobotBody(Scans(Sector(1, 0, 0)))->share, 0);
  poses_.clear();
  for (int i = 0; i < 260; ++i) {  // along a corridor, around, and back
    const bool is_back = i >= 160;
    const double x_m = i < 100 ? -20 + 0.4 * i : is_back ? 20 - 0.4 * (i - 160) : 20;
    poses_.push_back({x_m,
                      0,
                      i < 100   ? 0
                      : is_back ? std::numbers::pi
                                : std::numbers::pi * (i - 100) / 60});
  }
  room_ = {30, 1};
  auto scans = Scans(Sector(1, 0, 0));
  for (SignalSample& scan : scans) scan.value[2] = 8;
  EXPECT_EQ(FindRobotBody(scans)->share, 0);
}

// A wall that stays at one distance looks like the robot, until the robot turns.
TEST_F(RobotBodyTest, AWallAlongWhichTheRobotDroveIsNotCertainlyTheRobot) {
  for (const double waver_rad : {1e-9, 0.02}) {
    std::normal_distribution<double> waver(0, waver_rad);
    poses_.clear();
    room_ = {12, 6};
    for (int i = 0; i < 200; ++i) {
      poses_.push_back({-10 + 0.1 * i, -5.5 + 0.3 * waver(random_), waver(random_)});
    }
    const auto along = FindRobotBody(Scans(Sector(1, 0, 0)));
    ASSERT_TRUE(along.has_value());
    EXPECT_GT(along->share, 0);
    EXPECT_FALSE(along->is_certain) << waver_rad;
    for (int i = 0; i < 24; ++i) poses_.push_back({10, -5.5, std::numbers::pi / 48 * i});
    for (int i = 0; i < 50; ++i) {
      poses_.push_back({11.5, -4 + 0.1 * i, std::numbers::pi / 2 + waver(random_)});
    }
    const auto around = FindRobotBody(Scans(Sector(1, 0, 0)));
    ASSERT_TRUE(around.has_value());
    EXPECT_FALSE(around->is_certain) << waver_rad;
  }
}

TEST_F(RobotBodyTest, ARobotThatStandsTellsNothing) {
  poses_.assign(100, poses_[0]);
  EXPECT_FALSE(FindRobotBody(Scans(Behind)).has_value());
  EXPECT_FALSE(FindRobotBody({}).has_value());
}

// A robot that also turns its arm away, and beams that are lost on it.
TEST_F(RobotBodyTest, HitsBeyondTheRobotAndBesideItStay) {
  auto scans = Scans(Behind);
  const auto before = scans;
  scans[50].ranges_m[0] = 2.5F;    // beyond
  scans[50].ranges_m[1] = 0;       // lost on the robot
  scans[50].ranges_m[2] = 0.1F;    // nearer
  scans[50].ranges_m[23] = 0.25F;  // beside, half on the robot
  scans[51].ranges_m[23] = 0.35F;
  scans[50].ranges_m[25] = 0.25F;  // apart
  const auto body = FindRobotBody(scans);
  LeaveOut(*body, &scans);
  EXPECT_EQ(scans[50].ranges_m[0], 2.5F);
  EXPECT_EQ(scans[50].ranges_m[1], kNotMeasured_m);
  EXPECT_EQ(scans[50].ranges_m[2], kNotMeasured_m);
  EXPECT_EQ(scans[50].ranges_m[23], kNotMeasured_m);
  EXPECT_EQ(scans[51].ranges_m[23], 0.35F);
  EXPECT_EQ(scans[50].ranges_m[25], 0.25F);
  for (int i = 0; i < 180; ++i) {
    const bool is_robot = Behind(-180 + 2 * i) > 0;
    EXPECT_EQ(scans[0].ranges_m[i], is_robot ? kNotMeasured_m : before[0].ranges_m[i]) << i;
  }
  EXPECT_EQ(FindRobotBody(scans)->share, 0) << "nothing is left of it";
}

// A scanner that turns unevenly: the directions are found by their angles.
TEST_F(RobotBodyTest, ScansOfOtherNumbersOfBeamsShareDirections) {
  auto scans = Scans(Behind, 0.003);
  for (std::size_t k = 0; k < scans.size(); k += 3) {
    SignalSample& scan = scans[k];
    scan.value[1] *= 180.0 / 90;
    for (std::size_t i = 0; i < 90; ++i) scan.ranges_m[i] = scan.ranges_m[2 * i];
    scan.ranges_m.resize(90);
  }
  const auto body = FindRobotBody(scans);
  LeaveOut(*body, &scans);
  for (const SignalSample& scan : scans) {
    const auto num_left = static_cast<std::size_t>(
        std::ranges::count_if(scan.ranges_m, [](float range_m) { return range_m > 0; }));
    EXPECT_EQ(num_left, scan.ranges_m.size() == 90 ? 67U : 135U);
  }
}

TEST_F(RobotBodyTest, WhatIsStatedHoldsAndNothingElseIsLeftOut) {
  SensorConfig sensor;
  sensor.kind = SignalKind::kScan;
  sensor.max_range_m = 10;
  auto scans = Scans(Behind);
  EXPECT_TRUE(FinishScans(sensor, &scans).is_body_left_out);
  EXPECT_EQ(scans[7].ranges_m[0], kNotMeasured_m);
  scans = Scans(Behind);
  sensor.min_range_m = 0.1;
  const FoundInScans found = FinishScans(sensor, &scans);
  EXPECT_FALSE(found.is_body_left_out);
  EXPECT_EQ(found.body->remedy, "min_range_m = 0.30");
  EXPECT_GT(scans[7].ranges_m[0], 0);
  scans = Scans(Behind);
  sensor.min_range_m = 0.3;
  EXPECT_EQ(FinishScans(sensor, &scans).body->share, 0);
}

}  // namespace nightmap::robot_body_test
