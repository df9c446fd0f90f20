// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/keyscans.h"

#include <numbers>

#include "pipeline/base/input_error.h"
#include "pipeline/geometry/rigid2.h"
#include "pipeline/recording/scan_points.h"
#include "tests/test_data.h"

namespace nightmap::keyscans_test {

constexpr std::int64_t kPeriod_ns = 250'000'000;

// Right, ahead and left.
SignalSample Scan(std::int64_t time_ns, std::vector<float> ranges_m) {
  constexpr double kQuarterTurn_rad = std::numbers::pi / 2;
  return {time_ns, {-kQuarterTurn_rad, kQuarterTurn_rad, 10}, std::move(ranges_m)};
}

Signal Laser() {
  Signal laser{SignalKind::kScan, "laser", {}, {}};
  for (int i = 0; i < 8; ++i) {
    const auto range_m = static_cast<float>(i + 1);
    laser.samples.push_back(Scan(i * kPeriod_ns, {range_m, 2 * range_m, 1}));
  }
  return laser;
}

StampedPose KeyscanAt(std::int64_t time_ns, const Rigid2& pose = {}) {
  return {time_ns, pose.ToRigid3()};
}

std::vector<std::vector<Eigen::Vector2d>> PointsOfKeyscans(const Signal& scans,
                                                           const std::vector<StampedPose>& keyscans,
                                                           double max_range_m) {
  std::vector<std::vector<Eigen::Vector2d>> points;
  for (std::size_t i = 0; i < keyscans.size(); ++i) {
    points.push_back(PointsOfKeyscan(scans, keyscans, i, max_range_m));
  }
  return points;
}

TEST(Keyscans, PointsAreThoseOfTheScanAtTheSameTime) {
  const Signal laser = Laser();
  const auto points =
      PointsOfKeyscans(laser, {KeyscanAt(kPeriod_ns), KeyscanAt(3 * kPeriod_ns)}, 100);
  ASSERT_EQ(points.size(), 2U);
  for (const auto& [keyscan, sample] : {std::pair<std::size_t, std::size_t>(0, 1), {1, 3}}) {
    const auto expected = PointsInRobot(laser.samples[sample], laser).points_in_robot;
    ASSERT_EQ(points[keyscan].size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      EXPECT_EQ(points[keyscan][i], expected[i].head<2>());
    }
  }
  EXPECT_TRUE(PointsOfKeyscans(laser, {}, 100).empty());
}

TEST(Keyscans, PointsAreInTheRobotUpToTheLargestRange) {
  Signal laser = Laser();
  laser.robot_from_sensor.translation = {0.5, 0, 0.3};
  const auto points = PointsOfKeyscans(laser, {KeyscanAt(kPeriod_ns)}, 4.4);
  ASSERT_EQ(points[0].size(), 2U);  // what is 4 m ahead of the sensor is 4.5 m ahead of the robot
  EXPECT_TRUE(points[0][0].isApprox(Eigen::Vector2d(0.5, -2)));
  EXPECT_TRUE(points[0][1].isApprox(Eigen::Vector2d(0.5, 1)));
  EXPECT_EQ(PointsOfKeyscans(laser, {KeyscanAt(kPeriod_ns)}, 4.5)[0].size(), 3U);
}

TEST(Keyscans, AScanThatHitNothingHasNoPoints) {
  Signal laser = Laser();
  laser.samples[1].ranges_m = {0, 10, 11};
  EXPECT_THAT(PointsOfKeyscans(laser, {KeyscanAt(kPeriod_ns)}, 100),
              testing::ElementsAre(testing::IsEmpty()));
}

TEST(Keyscans, AKeyscanWithoutAScanIsNamed) {
  const char* const kText = "keyframes, scans: there is a keyscan and no scan at 0.3";
  NIGHTMAP_EXPECT_ERROR(
      InputError, PointsOfKeyscans(Laser(), {KeyscanAt(0), KeyscanAt(300'000'000)}, 100), kText);
  NIGHTMAP_EXPECT_ERROR(
      InputError, PointsOfKeyscans(Laser(), {KeyscanAt(8 * kPeriod_ns)}, 100), "no scan at 2.0");
  Signal none = Laser();
  none.samples.clear();
  NIGHTMAP_EXPECT_ERROR(InputError, PointsOfKeyscans(none, {KeyscanAt(0)}, 100), "no scan at 0.0");
}

// A robot that drives and turns while it scans sees a wall where it is, beam after beam.
TEST(Keyscans, TheMotionOverAScanIsThatTowardsTheNextKeyscan) {
  Signal laser = Laser();
  laser.scan_duration_s = 0.2;
  const Rigid2 first{0.3, {1, 2}};
  const Rigid2 next = first * Rigid2{0.5, {1, 0}};  // 4 / 5 of it is over when the scan is
  const std::vector<StampedPose> keyscans{KeyscanAt(kPeriod_ns, first),
                                          KeyscanAt(2 * kPeriod_ns, next)};
  const auto points = PointsOfKeyscans(laser, keyscans, 100);
  ASSERT_EQ(points[0].size(), 3U);
  for (int beam = 0; beam < 3; ++beam) {
    const double part = beam / 3.0 * 0.8;
    const Rigid2 start_from_robot{0.5 * part, {part, 0}};
    const double range_m = laser.samples[1].ranges_m[static_cast<std::size_t>(beam)];
    const Eigen::Vector2d seen =
        Eigen::Rotation2Dd((beam - 1) * std::numbers::pi / 2) * Eigen::Vector2d(range_m, 0);
    EXPECT_TRUE(points[0][static_cast<std::size_t>(beam)].isApprox(start_from_robot * seen, 1e-6))
        << beam;
  }
}

TEST(Keyscans, WithoutANextKeyscanSoonTheRobotIsTakenToStandStill) {
  Signal laser = Laser();
  const std::vector<StampedPose> keyscans{
      KeyscanAt(0), KeyscanAt(5 * kPeriod_ns, {1, {1, 1}}), KeyscanAt(6 * kPeriod_ns, {2, {1, 2}})};
  const auto still = PointsOfKeyscans(laser, keyscans, 100);
  laser.scan_duration_s = 0.2;
  const auto moved = PointsOfKeyscans(laser, keyscans, 100);
  EXPECT_EQ(moved[0], still[0]);  // the next one is 1.25 s later
  EXPECT_NE(moved[1], still[1]);
  EXPECT_EQ(moved[2], still[2]);  // the last one
}

SensorEdge Edge(std::int64_t source_ns, std::int64_t target_ns) {
  return {EdgeKind::kOdometry, source_ns, target_ns, {}, Matrix6d::Identity()};
}

TEST(Keyscans, EdgesLeadFromEachKeyscanToTheNext) {
  const std::vector<StampedPose> keyscans{KeyscanAt(1), KeyscanAt(2), KeyscanAt(4)};
  EXPECT_NO_THROW(CheckEdgesOfKeyscans(keyscans, {Edge(1, 2), Edge(2, 4)}));
  EXPECT_NO_THROW(CheckEdgesOfKeyscans({KeyscanAt(1)}, {}));
  const std::vector<std::vector<SensorEdge>> wrong{{},
                                                   {Edge(1, 2)},
                                                   {Edge(2, 4)},
                                                   {Edge(1, 2), Edge(2, 4), Edge(4, 5)},
                                                   {Edge(1, 2), Edge(2, 5)},
                                                   {Edge(1, 2), Edge(1, 4)},
                                                   {Edge(2, 1), Edge(2, 4)},
                                                   {Edge(2, 4), Edge(1, 2)}};
  for (const auto& edges : wrong) {
    NIGHTMAP_EXPECT_ERROR(InputError,
                          (CheckEdgesOfKeyscans(keyscans, edges), 0),
                          "odometry, keyframes: their keyscans differ");
  }
  NIGHTMAP_EXPECT_ERROR(InputError, (CheckEdgesOfKeyscans({}, {}), 0), "their keyscans differ");
}

}  // namespace nightmap::keyscans_test
