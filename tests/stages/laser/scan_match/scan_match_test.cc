// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_match/scan_match.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/base/input_error.h"
#include "pipeline/base/random.h"
#include "tests/laser_building.h"
#include "tests/test_data.h"

namespace nightmap::scan_match_test {

constexpr int kNumScans = 120;

// A hall of 12 x 8 m with two pillars.
const Building kHall{{{-6, -4}, {6, 4}}, {{-1, 2.5}, {-0.4, 3.1}}, {{2, -3.3}, {2.5, -2.6}}};

float RangeOf(const Building& building, const Rigid2& start_from_robot, double angle_rad) {
  return static_cast<float>(RangeToWall_m(
      building, start_from_robot.translation, start_from_robot.heading_rad + angle_rad));
}

SignalSample ScanAt(std::int64_t time_ns,
                    const Building& boxes,
                    const Rigid2& start_from_robot,
                    Random& random) {
  SignalSample sample{time_ns, {-std::numbers::pi / 2, std::numbers::pi / 180, 30}, {}};
  for (int beam = 0; beam <= 180; ++beam) {
    const double angle_rad = (beam - 90) * std::numbers::pi / 180;
    sample.ranges_m.push_back(RangeOf(boxes, start_from_robot, angle_rad) +
                              static_cast<float>(random.Uniform(-0.02, 0.02)));
  }
  return sample;
}

// On an ellipse, counter-clockwise, once around at 10 scans per second.
Rigid2 TruthAt(double scan) {
  const double phase = 2 * std::numbers::pi * scan / kNumScans;
  return {std::atan2(1.2 * std::cos(phase), -2.5 * std::sin(phase)),
          {2.5 * std::cos(phase), 1.2 * std::sin(phase)}};
}

// Likewise, but from rest: at full speed after 20 scans.
Rigid2 TruthFromRestAt(double scan) { return TruthAt(scan < 20 ? scan * scan / 40 : scan - 10); }

using Truth = Rigid2 (*)(double scan);

// The beams of a scan are spread over duration_s.
Signal Scans(double duration_s = 0, Truth truth = TruthAt) {
  Signal signal{SignalKind::kScan, "laser", {}, {}, duration_s};
  Random random(1);
  for (int i = 0; i < kNumScans; ++i) {
    SignalSample& scan =
        signal.samples.emplace_back(ScanAt(100'000'000LL * i, kHall, truth(i), random));
    if (duration_s == 0) continue;
    for (int beam = 0; beam <= 180; ++beam) {
      const double angle_rad = (beam - 90) * std::numbers::pi / 180;
      scan.ranges_m[static_cast<std::size_t>(beam)] =
          RangeOf(kHall, truth(i + 10 * duration_s * beam / 181), angle_rad);
    }
  }
  return signal;
}

// Wheels that turn 5 % too far and drive 5 % too far.
Signal Wheels(Truth truth = TruthAt) {
  Signal signal{SignalKind::kOdometry, "wheels", {}, {}};
  Rigid2 pose;
  for (int i = 0; i < kNumScans; ++i) {
    if (i > 0) {
      const Rigid2 motion = truth(i - 1).Inverse() * truth(i);
      pose = pose * Rigid2{1.05 * motion.heading_rad, 1.05 * motion.translation};
    }
    signal.samples.push_back(
        {100'000'000LL * i, {pose.translation.x(), pose.translation.y(), pose.heading_rad}, {}});
  }
  return signal;
}

ScanMatchResult Match(const ScanMatchInput& input, const ScanMatchOptions& options = {}) {
  Progress progress("scan_match", false);
  return RunScanMatch(options, input, progress);
}

double LargestError_m(const ScanMatchResult& result, Truth truth = TruthAt) {
  double largest_m = 0;
  for (int i = 0; i < kNumScans; ++i) {
    const Rigid2 start_from_robot = truth(0).Inverse() * truth(i);
    const Rigid2& found = result.scans[static_cast<std::size_t>(i)].start_from_robot;
    largest_m = std::max(largest_m, (found.translation - start_from_robot.translation).norm());
  }
  return largest_m;
}

TEST(ScanMatch, FollowsTheRobotWithAndWithoutWheels) {
  for (const bool has_wheels : {true, false}) {
    ScanMatchInput input{{Scans()}, {}};
    if (has_wheels) input.odometry = {Wheels()};
    const ScanMatchResult result = Match(input);
    ASSERT_EQ(result.scans.size(), static_cast<std::size_t>(kNumScans));
    EXPECT_LT(LargestError_m(result), 0.04) << has_wheels;
    EXPECT_EQ(result.odometry_sensor, has_wheels ? "wheels" : "");
    EXPECT_TRUE(std::ranges::all_of(result.scans, &MatchedScan::is_matched));
  }
}

// The robot turns and drives while it scans.
TEST(ScanMatch, TakesTheMotionOverAScanBack) {
  for (const bool has_wheels : {true, false}) {
    ScanMatchInput input{{Scans(0.075, TruthFromRestAt)}, {}};
    if (has_wheels) input.odometry = {Wheels(TruthFromRestAt)};
    const double moved_m = LargestError_m(Match(input), TruthFromRestAt);
    input.scans[0].scan_duration_s = 0;
    const double still_m = LargestError_m(Match(input), TruthFromRestAt);
    EXPECT_LT(moved_m, 0.05) << has_wheels;
    EXPECT_GT(still_m, 3 * moved_m) << has_wheels;
  }
}

TEST(ScanMatch, EdgesJoinTheKeyscans) {
  const ScanMatchResult result = Match({{Scans()}, {Wheels()}});
  std::vector<MatchedScan> keyscans;
  for (const MatchedScan& scan : result.scans) {
    if (scan.is_keyscan) keyscans.push_back(scan);
  }
  EXPECT_TRUE(result.scans[0].is_keyscan);
  ASSERT_GT(keyscans.size(), 10U);
  ASSERT_EQ(result.edges.edges.size(), keyscans.size() - 1);
  EXPECT_EQ(result.edges.sensor, "laser");
  for (std::size_t i = 0; i + 1 < keyscans.size(); ++i) {
    const SensorEdge& edge = result.edges.edges[i];
    EXPECT_EQ(edge.source_time_ns, keyscans[i].time_ns);
    EXPECT_EQ(edge.target_time_ns, keyscans[i + 1].time_ns);
    EXPECT_LT(std::sqrt(edge.covariance(3, 3)), 0.05);
    const Rigid3 a = keyscans[i].start_from_robot.ToRigid3();
    const Rigid3 b = keyscans[i + 1].start_from_robot.ToRigid3();
    EXPECT_LT((a.translation - (b * edge.target_from_source).translation).norm(), 1e-9);
  }
}

// In a bare corridor the robot turns from looking across it to looking along it, and drives on.
// The part that the scans do not tell is ahead then, and to the side of its first pose, which is
// the frame of the submap.
TEST(ScanMatch, AnEdgeStatesItsCovarianceAlongTheAxesOfItsTarget) {
  const Building corridor{{{-200, -1}, {200, 1}}};
  Signal scans{SignalKind::kScan, "laser", {}, {}};
  Random random(2);
  for (int i = 0; i <= 60; ++i) {
    const double heading_rad = std::numbers::pi / 2 * std::max(0, 20 - i) / 20;
    const Rigid2 truth{heading_rad, {0.05 * std::max(0, i - 20), 0}};
    scans.samples.push_back(ScanAt(100'000'000LL * i, corridor, truth, random));
  }
  ScanMatchOptions options;
  options.max_range_m = 6;
  Progress progress("scan_match", false);
  const ScanMatchResult result = RunScanMatch(options, {{scans}, {}}, progress);
  ASSERT_GT(result.edges.edges.size(), 10U);
  const Matrix6d& covariance = result.edges.edges.back().covariance;
  EXPECT_GT(covariance(3, 3), 4 * covariance(4, 4));
}

TEST(ScanMatch, AKeyscanIsOneThatTheRobotMovedTo) {
  for (const double distance_m : {0.15, 0.5}) {
    ScanMatchOptions options;
    options.keyscan_distance_m = distance_m;
    options.keyscan_angle_rad = 0.3;
    const ScanMatchResult result = Match({{Scans()}, {Wheels()}}, options);
    Rigid2 last = result.scans[0].start_from_robot;
    for (std::size_t i = 1; i < result.scans.size(); ++i) {
      const Rigid2 motion = last.Inverse() * result.scans[i].start_from_robot;
      const bool has_moved =
          motion.translation.norm() > distance_m || std::abs(motion.heading_rad) > 0.3;
      EXPECT_EQ(result.scans[i].is_keyscan, has_moved) << i;
      if (has_moved) last = result.scans[i].start_from_robot;
    }
  }
}

TEST(ScanMatch, AScanThatSeesNothingKeepsItsPrediction) {
  ScanMatchInput input{{Scans()}, {Wheels()}};
  for (float& range_m : input.scans[0].samples[60].ranges_m) range_m = 81.8F;
  const ScanMatchResult result = Match(input);
  EXPECT_FALSE(result.scans[60].is_matched);
  EXPECT_FALSE(result.scans[60].is_keyscan);
  EXPECT_TRUE(result.scans[61].is_matched);
  EXPECT_LT(LargestError_m(result), 0.05);
}

// Half way the laser is covered for 1 s, while the robot is carried into a chamber of 2.6 x 2 m;
// there it drives straight, past a pillar. The wheels do not turn while it is carried.
struct CarriedAway {
  static constexpr int kCovered = 60, kFree = 70, kEnd = 110;
  static constexpr double kStep_m = 0.04;

  static Rigid2 TruthInChamber(int scan) { return {0, {-1.1 + kStep_m * (scan - kFree), -0.2}}; }

  CarriedAway() : input{{Scans()}, {Wheels()}} {
    const Building chamber{{{-1.5, -0.9}, {1.1, 1.1}}, {{0.2, 0.5}, {0.5, 0.8}}};
    std::vector<SignalSample>& scans = input.scans[0].samples;
    std::vector<SignalSample>& wheels = input.odometry[0].samples;
    Random random(2);
    for (int i = kCovered; i < kEnd; ++i) {
      const auto idx = static_cast<std::size_t>(i);
      const std::int64_t time_ns = scans[idx].time_ns;
      scans[idx] = ScanAt(time_ns, chamber, TruthInChamber(i), random);
      if (i < kFree) std::ranges::fill(scans[idx].ranges_m, 81.8F);
      wheels[idx].value = wheels[kCovered - 1].value;
      const double heading_rad = wheels[idx].value[2];
      const double driven_m = kStep_m * std::max(0, i - kFree);
      wheels[idx].value[0] += driven_m * std::cos(heading_rad);
      wheels[idx].value[1] += driven_m * std::sin(heading_rad);
    }
    scans.resize(kEnd);
    wheels.resize(kEnd);
  }

  ScanMatchInput input;
};

TEST(ScanMatch, ARobotThatIsCarriedElsewhereGoesOnInANewSubmap) {
  constexpr int kFree = CarriedAway::kFree;
  for (const bool has_wheels : {true, false}) {
    SCOPED_TRACE(has_wheels);
    ScanMatchInput input = CarriedAway().input;
    if (!has_wheels) input.odometry.clear();
    const ScanMatchResult result = Match(input);
    const auto first = std::find_if(
        result.scans.begin() + kFree, result.scans.end(), std::mem_fn(&MatchedScan::is_keyscan));
    ASSERT_NE(first, result.scans.end());
    EXPECT_FALSE(first->is_matched);  // it fits nowhere, and begins the new submap
    const auto begin = static_cast<int>(first - result.scans.begin());
    EXPECT_LT(begin, kFree + 6);
    for (int i = CarriedAway::kCovered; i < CarriedAway::kEnd; ++i) {
      const MatchedScan& scan = result.scans[static_cast<std::size_t>(i)];
      EXPECT_EQ(scan.is_matched, i > begin) << i;
      if (i <= begin) continue;
      const Rigid2 truth =
          CarriedAway::TruthInChamber(begin).Inverse() * CarriedAway::TruthInChamber(i);
      const Rigid2 found = first->start_from_robot.Inverse() * scan.start_from_robot;
      EXPECT_LT((found.translation - truth.translation).norm(), 0.04) << i;
      EXPECT_NEAR(found.heading_rad, truth.heading_rad, 0.03) << i;
    }
    for (const SensorEdge& edge : result.edges.edges) {
      const double sigma_m = std::sqrt(edge.covariance(3, 3));
      if (edge.target_time_ns == first->time_ns) {
        EXPECT_GT(sigma_m, 0.3);  // ten predictions, of 0.1 m and more
      } else {
        EXPECT_LT(sigma_m, 0.05);
      }
    }
  }
}

TEST(ScanMatch, SensorsThatAreNotThereAreNamed) {
  NIGHTMAP_EXPECT_ERROR(InputError, Match({}), "no sensor of the site scans");
  ScanMatchInput without{{Scans()}, {}};
  without.scans[0].samples.clear();
  NIGHTMAP_EXPECT_ERROR(
      InputError, Match(without), "sensor 'laser' has no scan; add its [[signal]]");
  ScanMatchInput two{{Scans(), Scans()}, {}};
  two.scans[1].sensor_id = "rear";
  NIGHTMAP_EXPECT_ERROR(UsageError, Match(two), "choose one of the sensors that scan: laser, rear");
  ScanMatchOptions options;
  options.scan_sensor = "rear";
  EXPECT_EQ(Match(two, options).scan_sensor, "rear");
}

TEST(ScanMatch, OdometryIsTheOnlyOneOrTheNamedOneOrNone) {
  ScanMatchInput input{{Scans()}, {Wheels()}};
  ScanMatchOptions options;
  options.odometry_sensor = "none";
  EXPECT_EQ(Match(input, options).odometry_sensor, "");
  options.odometry_sensor = "wheel";
  NIGHTMAP_EXPECT_ERROR(
      UsageError, Match(input, options), "one of the sensors of odometry: wheels");
  input.odometry.push_back(Wheels());
  input.odometry[1].sensor_id = "gyro";
  NIGHTMAP_EXPECT_ERROR(
      UsageError,
      Match(input),
      "scan_match.odometry_sensor is '': choose \"none\" or one of the sensors of "
      "odometry: wheels, gyro");
  options.odometry_sensor = "gyro";
  EXPECT_EQ(Match(input, options).odometry_sensor, "gyro");
}

}  // namespace nightmap::scan_match_test
