// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/hold_out_scans/hold_out_scans.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/recording/scan_points.h"
#include "tests/laser_building.h"
#include "tests/test_data.h"

namespace nightmap::hold_out_scans_test {

const Building kHall = {{{-12, -8}, {12, 8}}, {{-3, -2}, {4, 3}}};

// Three laps around the hall, so that every block is near scans of the others.
HoldOutScansInput Laps() {
  const auto poses = DriveAround({9, 5}, 1, 0.2, 3);
  return {{ScansAt(kHall, poses, 0.01)}, KeyscansAt(poses)};
}

double PathTo(const std::vector<StampedPose>& trajectory, std::int64_t time_ns) {
  double path_m = 0;
  for (std::size_t i = 1; i < trajectory.size() && trajectory[i].time_ns <= time_ns; ++i) {
    path_m += (trajectory[i].pose.translation - trajectory[i - 1].pose.translation).norm();
  }
  return path_m;
}

TEST(HoldOutScans, EachThirdBlockIsHeldOutAndNothingIsLost) {
  const HoldOutScansInput input = Laps();
  const HeldOutScans result = RunHoldOutScans({}, input);
  ASSERT_EQ(result.mapped.size(), 1U);
  EXPECT_EQ(result.mapped[0].samples.size() + result.num_held_out, input.trajectory.size());
  for (const SignalSample& scan : result.mapped[0].samples) {
    EXPECT_NE(static_cast<int>(PathTo(input.trajectory, scan.time_ns) / 10) % 3, 2);
  }
  EXPECT_NEAR(static_cast<double>(result.num_held_out),
              static_cast<double>(input.trajectory.size()) / 3,
              0.05 * static_cast<double>(input.trajectory.size()));
}

TEST(HoldOutScans, QueriesAreApartAndHaveTheirScanAndTruePose) {
  const HoldOutScansInput input = Laps();
  const HeldOutScans result = RunHoldOutScans({}, input);
  ASSERT_EQ(result.queries.size(), result.truth.size());
  ASSERT_GT(result.queries.size(), 20U);
  double last_m = -1;
  for (std::size_t i = 0; i < result.queries.size(); ++i) {
    const ScanQuery& query = result.queries[i];
    const double path_m = PathTo(input.trajectory, query.time_ns);
    EXPECT_EQ(static_cast<int>(path_m / 10) % 3, 2);
    EXPECT_GE(path_m - last_m, 0.5 - 1e-9);
    last_m = path_m;
    EXPECT_EQ(query.name, TimeToString(query.time_ns));
    const int row = FindPose(input.trajectory, query.time_ns);
    ASSERT_GE(row, 0);
    const auto& pose = input.trajectory[static_cast<std::size_t>(row)].pose;
    EXPECT_EQ(result.truth[i].pose.translation, pose.translation);
    ASSERT_EQ(query.scans.size(), 1U);
    const auto& samples = input.scans[0].samples;
    const auto scan = std::ranges::find(samples, query.time_ns, &SignalSample::time_ns);
    EXPECT_EQ(query.scans[0].ranges_m, scan->ranges_m);
    EXPECT_FALSE(query.rough_position.has_value());
  }
}

TEST(HoldOutScans, RoughPositionsAreWithinTheirRadiusAndFollowTheSeed) {
  HoldOutScansOptions options;
  options.rough_radius_m = 5;
  const HeldOutScans result = RunHoldOutScans(options, Laps());
  double farthest_m = 0, sum_m2 = 0;
  for (std::size_t i = 0; i < result.queries.size(); ++i) {
    const auto& rough = result.queries[i].rough_position;
    ASSERT_TRUE(rough.has_value());
    EXPECT_EQ(rough->radius_m, 5);
    const double off_m = (rough->point_in_map - result.truth[i].pose.translation.head<2>()).norm();
    farthest_m = std::max(farthest_m, off_m);
    sum_m2 += off_m * off_m;
  }
  EXPECT_LE(farthest_m, 5);
  // Evenly over the disc: the mean square is half the squared radius.
  EXPECT_NEAR(sum_m2 / static_cast<double>(result.queries.size()), 12.5, 4);
  const HeldOutScans again = RunHoldOutScans(options, Laps());
  EXPECT_EQ(again.queries[3].rough_position->point_in_map,
            result.queries[3].rough_position->point_in_map);
  options.seed = 2;
  EXPECT_NE(RunHoldOutScans(options, Laps()).queries[3].rough_position->point_in_map,
            result.queries[3].rough_position->point_in_map);
}

TEST(HoldOutScans, QueriesBeyondTheMostAreLeftOutEvenly) {
  const HeldOutScans all = RunHoldOutScans({}, Laps());
  HoldOutScansOptions options;
  options.max_queries = 7;
  const HeldOutScans some = RunHoldOutScans(options, Laps());
  ASSERT_EQ(some.queries.size(), 7U);
  ASSERT_EQ(some.truth.size(), 7U);
  EXPECT_EQ(some.num_left_out, all.queries.size() - 7);
  EXPECT_EQ(all.num_left_out, 0U);
  std::vector<std::size_t> idxs;
  for (std::size_t i = 0; i < 7; ++i) {
    const auto time_ns = some.queries[i].time_ns;
    EXPECT_EQ(some.truth[i].time_ns, time_ns);
    const auto found = std::ranges::find(all.queries, time_ns, &ScanQuery::time_ns);
    ASSERT_NE(found, all.queries.end());
    EXPECT_EQ(some.queries[i].scans[0].ranges_m, found->scans[0].ranges_m);
    idxs.push_back(static_cast<std::size_t>(found - all.queries.begin()));
  }
  for (std::size_t i = 1; i < 7; ++i) {
    EXPECT_NEAR(
        static_cast<double>(idxs[i] - idxs[i - 1]), static_cast<double>(all.queries.size()) / 7, 1);
  }
}

TEST(HoldOutScans, AShortWayLeavesNoQueryAndIsMappedWhole) {
  const auto poses = DriveAround({9, 5}, 1, 0.2, 0.3);
  const HeldOutScans result = RunHoldOutScans({}, {{ScansAt(kHall, poses, 0)}, KeyscansAt(poses)});
  EXPECT_TRUE(result.queries.empty());
  EXPECT_EQ(result.mapped[0].samples.size(), poses.size());
}

TEST(HoldOutScans, ScansFarFromTheMapAreCountedAndNoQueries) {
  const auto poses =
      DriveAround({9, 5}, 1, 0.2, 0.9);  // once around: blocks end where others begin
  HoldOutScansOptions options;
  options.near_m = 0.05;
  const HeldOutScans result =
      RunHoldOutScans(options, {{ScansAt(kHall, poses, 0)}, KeyscansAt(poses)});
  EXPECT_GT(result.num_held_out, 0U);
  EXPECT_EQ(result.num_far, result.num_held_out);
  EXPECT_TRUE(result.queries.empty());
}

TEST(HoldOutScans, AQueryHasThePointsOfItsScanHoweverTheScannerIsMounted) {
  HoldOutScansInput input = Laps();
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(1, Eigen::Vector3d::UnitZ()));
  const Eigen::Quaterniond upside_down(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()));
  for (const Eigen::Quaterniond& rotation : {turned, upside_down, turned * upside_down}) {
    input.scans[0].robot_from_sensor = {rotation, {0.3, 0.1, 0.4}};
    const HeldOutScans result = RunHoldOutScans({}, input);
    const ScanQuery& query = result.queries.at(5);
    const auto& samples = input.scans[0].samples;
    const auto scan = std::ranges::find(samples, query.time_ns, &SignalSample::time_ns);
    const auto expected = PointsInRobot(*scan, input.scans[0]).points_in_robot;
    const auto found = PointsInQuery(query, 100);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_NEAR((found[i] - expected[i].head<2>()).norm(), 0, 1e-9);
    }
  }
}

TEST(HoldOutScans, TheScannerIsTheOneThatIsNamed) {
  HoldOutScansInput input = Laps();
  input.scans.push_back(input.scans[0]);
  input.scans[1].sensor_id = "rear";
  NIGHTMAP_EXPECT_ERROR(UsageError, RunHoldOutScans({}, input), "hold_out_scans.sensor");
  HoldOutScansOptions options;
  options.sensor = "rear";
  EXPECT_EQ(RunHoldOutScans(options, input).mapped[0].sensor_id, "rear");
}

}  // namespace nightmap::hold_out_scans_test
