// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_queries/scan_queries.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/base/error.h"
#include "tests/test_data.h"

namespace nightmap::scan_queries_test {

constexpr double kStep_rad = M_PI / 180;

SignalSample Scan(std::int64_t time_ns) {
  return {time_ns, {-M_PI, kStep_rad, 30}, std::vector<float>(360, 2.F)};
}

ScanLog Log(const std::string& name, const std::vector<std::int64_t>& times_ns) {
  ScanLog log;
  log.name = name;
  log.source = "s.toml:9";
  for (const std::int64_t time_ns : times_ns) log.scans.push_back(Scan(time_ns));
  return log;
}

TEST(ScanQueries, EachScanIsAQueryNamedAfterItsLog) {
  ScanLog several = Log("lab/a.log", {5, 8});
  several.robot_from_laser = {0.5, {0.1, 0.2}};
  several.rough_position = RoughPosition{{1, 2}, 3};
  const auto queries = RunScanQueries({}, {several, Log("b.log", {9})});
  ASSERT_EQ(queries.size(), 3U);
  EXPECT_EQ(queries[0].name, "lab/a.log#1");
  EXPECT_EQ(queries[1].name, "lab/a.log#2");
  EXPECT_EQ(queries[2].name, "b.log");
  EXPECT_EQ(queries[1].time_ns, 8);
  ASSERT_EQ(queries[1].scans.size(), 1U);
  const QueryScan& scan = queries[1].scans[0];
  EXPECT_EQ(scan.query_from_laser.heading_rad, 0.5);
  EXPECT_EQ(scan.query_from_laser.translation, Eigen::Vector2d(0.1, 0.2));
  EXPECT_EQ(scan.first_angle_rad, -M_PI);
  EXPECT_EQ(scan.step_angle_rad, kStep_rad);
  EXPECT_EQ(scan.limit_m, 30);
  EXPECT_EQ(scan.ranges_m, several.scans[1].ranges_m);
  ASSERT_TRUE(queries[1].rough_position.has_value());
  EXPECT_EQ(queries[1].rough_position->radius_m, 3);
  EXPECT_FALSE(queries[2].rough_position.has_value());
}

TEST(ScanQueries, TimesIncreaseOverAllLogsAndStayWhereTheyDo) {
  const auto queries =
      RunScanQueries({}, {Log("a", {7, 7, 5, 20}), Log("b", {6, 30}), Log("c", {30})});
  std::vector<std::int64_t> times_ns;
  for (const ScanQuery& query : queries) times_ns.push_back(query.time_ns);
  EXPECT_EQ(times_ns, (std::vector<std::int64_t>{7, 8, 9, 20, 21, 30, 31}));
}

TEST(ScanQueries, NoLogsAreNoQueries) { EXPECT_TRUE(RunScanQueries({}, {}).empty()); }

// Where a scan of a robot that turned sees the point that lies ahead of its laser by 2 m.
TEST(ScanQueries, ARobotThatTurnedSeesItsScansFromWhereItBegan) {
  ScanLog log = Log("turn.log", {4, 6, 9});
  log.turn = true;
  log.robot_from_laser = {0, {0.3, 0}};
  log.odometry_from_robot = {{M_PI / 2, {10, 20}}, {M_PI, {10, 20}}, {M_PI + 0.1, {10, 20.5}}};
  const auto queries = RunScanQueries({}, {log});
  ASSERT_EQ(queries.size(), 1U);
  EXPECT_EQ(queries[0].name, "turn.log");
  EXPECT_EQ(queries[0].time_ns, 4);
  ASSERT_EQ(queries[0].scans.size(), 3U);
  const auto ahead = [&](std::size_t i) -> Eigen::Vector2d {
    return queries[0].scans[i].query_from_laser * Eigen::Vector2d(2, 0);
  };
  EXPECT_LT((ahead(0) - Eigen::Vector2d(2.3, 0)).norm(), 1e-12);
  EXPECT_LT((ahead(1) - Eigen::Vector2d(0, 2.3)).norm(), 1e-12);  // turned left by 90 deg
  const Eigen::Vector2d moved(0.5, 0);                            // along the first heading
  const Eigen::Vector2d turned(std::cos(M_PI / 2 + 0.1), std::sin(M_PI / 2 + 0.1));
  EXPECT_LT((ahead(2) - moved - 2.3 * turned).norm(), 1e-12);
}

TEST(ScanQueries, ARobotThatDroveDidNotTurnOnTheSpot) {
  ScanLog log = Log("drive.log", {4, 6});
  log.turn = true;
  log.odometry_from_robot = {{0, {0, 0}}, {0, {3, 0}}};
  NIGHTMAP_EXPECT_ERROR(DataError,
                        RunScanQueries({}, {log}),
                        "drive.log: at scan 2 the robot is 3.00 m from where the log begins, more "
                        "than max_turn_m = 1: cut the log to a turn on the spot, or correct "
                        "`turn` in s.toml:9");
  ScanQueriesOptions options;
  options.max_turn_m = 3;
  EXPECT_EQ(RunScanQueries(options, {log}).at(0).scans.size(), 2U);
}

}  // namespace nightmap::scan_queries_test
