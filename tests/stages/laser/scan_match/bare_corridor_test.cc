// SPDX-License-Identifier: Apache-2.0
// scan_match in a corridor whose ends the scanner does not reach.
#include <algorithm>
#include <cmath>

#include "stages/laser/scan_match/scan_match.h"
#include "tests/laser_building.h"
#include "tests/test_data.h"

namespace nightmap::bare_corridor_test {

// Two rooms of 10 x 6 m, and 30 m of corridor, 2 m wide, between them.
const Building kRooms{{{-10, -3}, {40, 3}},
                      {{0, 1}, {30, 4}},
                      {{0, -4}, {30, -1}},
                      {{-6, 1.5}, {-5, 2.5}},
                      {{34, -2}, {35.5, -1}}};
constexpr double kReach_m = 8;
constexpr double kStep_m = 0.1;
constexpr double kWheelsPerMetre = 1.03;

std::vector<Rigid2> ThereAndBack() {
  std::vector<Rigid2> poses;
  for (double x = -8; x < 38; x += kStep_m) poses.push_back({0, {x, 0}});
  for (double turn = 0.1; turn < std::numbers::pi; turn += 0.1) poses.push_back({turn, {38, 0}});
  for (double x = 38; x > -8; x -= kStep_m) poses.push_back({std::numbers::pi, {x, 0}});
  return poses;
}

ScanMatchInput Recorded(const std::vector<Rigid2>& poses, bool has_wheels) {
  ScanMatchInput input{{ScansAt(kRooms, poses, 0.015)}, {}};
  Signal wheels{SignalKind::kOdometry, "wheels", {}, {}};
  Rigid2 pose;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    SignalSample& scan = input.scans[0].samples[i];
    scan.time_ns /= 5;  // ScansAt makes one a second
    scan.value[2] = kReach_m;
    if (i > 0) {
      Rigid2 motion = poses[i - 1].Inverse() * poses[i];
      motion.translation *= kWheelsPerMetre;
      pose = pose * motion;
    }
    wheels.samples.push_back(
        {scan.time_ns, {pose.translation.x(), pose.translation.y(), pose.heading_rad}, {}});
  }
  if (has_wheels) input.odometry = {wheels};
  return input;
}

ScanMatchResult Match(const ScanMatchInput& input) {
  Progress progress("scan_match", false);
  return RunScanMatch({}, input, progress);
}

double LargestError_m(const ScanMatchResult& result, const std::vector<Rigid2>& poses) {
  double largest_m = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Rigid2 truth = poses[0].Inverse() * poses[i];
    const Rigid2& found = result.scans[i].start_from_robot;
    largest_m = std::max(largest_m, (found.translation - truth.translation).norm());
  }
  return largest_m;
}

// 30 m at the wheels' scale would be 0.9 m too long.
TEST(BareCorridor, TheWayIsThatOfTheWheelsAtTheScaleThatTheRoomsTell) {
  const std::vector<Rigid2> poses = ThereAndBack();
  const ScanMatchResult result = Match(Recorded(poses, true));
  ASSERT_TRUE(result.wheel_scale.has_value());
  EXPECT_NEAR(*result.wheel_scale, 1 / kWheelsPerMetre, 0.003);
  EXPECT_LT(LargestError_m(result, poses), 0.12);
}

TEST(BareCorridor, TheCorridorsAxisIsUnclearInItsMiddleAndNothingInTheRooms) {
  const std::vector<Rigid2> poses = ThereAndBack();
  for (const bool has_wheels : {true, false}) {
    const ScanMatchResult result = Match(Recorded(poses, has_wheels));
    for (std::size_t i = 1; i < poses.size(); ++i) {
      const double x_m = poses[i].translation.x();
      const auto& along = result.scans[i].unclear_in_robot;
      if (x_m > 9 && x_m < 21) {
        ASSERT_TRUE(along.has_value()) << x_m;
        EXPECT_GT(std::abs(along->x()), 0.99) << x_m;
      }
      if (x_m < -4 || x_m > 34) {
        EXPECT_FALSE(along.has_value()) << x_m;
      }
    }
  }
}

// The edges say that the way along the corridor is known by wheels alone, and the one across by
// walls.
TEST(BareCorridor, TheEdgesAreUncertainAlongIt) {
  const std::vector<Rigid2> poses = ThereAndBack();
  const ScanMatchResult result = Match(Recorded(poses, true));
  int num = 0;
  for (const SensorEdge& edge : result.edges.edges) {
    const double x_m =
        poses[static_cast<std::size_t>(edge.target_time_ns / 200'000'000)].translation.x();
    if (x_m < 10 || x_m > 20) continue;
    ++num;
    EXPECT_GT(std::sqrt(edge.covariance(3, 3)), 0.03);
    EXPECT_LT(std::sqrt(edge.covariance(4, 4)), 0.02);
  }
  EXPECT_GT(num, 50);
}

}  // namespace nightmap::bare_corridor_test
