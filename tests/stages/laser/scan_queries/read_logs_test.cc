// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_queries/read_logs.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "tests/test_data.h"

namespace nightmap::read_logs_test {

// n ranges x y theta odom_x odom_y odom_theta time host logger_time
constexpr const char* kLog =
    "PARAM laser off\n"
    "ODOM 1 2 3 0 0 0 10.5 host 10.5\n"
    "FLASER 3 1.5 2.5 81 9 9 9 1 2 0.5 10.5 host 10.5\n"
    "FLASER 3 1.5 oops 81 9 9 9 1 2 0.5 11 host 11\n"
    "FLASER 3 1.6 2.6 81 9 9 9 1.25 2 7.5 12 host 12\n"
    "FLASER 3 1.6 2.6 81 9 9 9 1.25 2";  // cut off

class ReadLogs : public testing::Test {
 protected:
  ReadLogs() {
    site_.root = "lab";
    SensorConfig& sensor = site_.sensors.emplace_back();
    sensor.id = "laser";
    sensor.kind = SignalKind::kScan;
    sensor.start_angle_deg = -90;
    sensor.angle_step_deg = 90;
    sensor.robot_from_sensor.translation = {0.2, 0.1, 0.4};
    std::filesystem::create_directories(folder_.Path() / "data/lab");
  }

  ScanQueryConfig& Ask(const std::string& scans) {
    ScanQueryConfig& query = site_.scan_queries.emplace_back();
    query.scans = scans;
    query.source = "s.toml:9";
    return query;
  }

  void Write(const std::string& name, const std::string& text) {
    WriteFile(folder_.Path() / "data/lab" / name, text);
  }

  ScanLogs Read(double max_failed_ratio = 0.5) const {
    return ReadScanLogs(site_, folder_.Path() / "data", max_failed_ratio);
  }

  TemporaryFolder folder_;
  SiteConfig site_;
};

TEST_F(ReadLogs, LinesThatAreNoScanAreLeftOutAndNamed) {
  Write("a.log", kLog);
  Ask("a.log");
  const ScanLogs read = Read();
  ASSERT_EQ(read.logs.size(), 1U);
  const ScanLog& log = read.logs[0];
  EXPECT_EQ(log.name, "a.log");
  ASSERT_EQ(log.scans.size(), 2U);
  EXPECT_EQ(log.scans[0].time_ns, 10'500'000'000);
  EXPECT_EQ(log.scans[0].ranges_m, (std::vector<float>{1.5F, 2.5F, 81}));
  EXPECT_EQ(log.scans[0].value, Eigen::Vector3d(-M_PI / 2, M_PI / 2, 80));
  EXPECT_EQ(log.robot_from_laser.translation, Eigen::Vector2d(0.2, 0.1));
  EXPECT_FALSE(log.rough_position.has_value());
  ASSERT_EQ(read.problems.size(), 2U);
  EXPECT_TRUE(read.problems[0].starts_with("a.log:4: ")) << read.problems[0];
  EXPECT_TRUE(read.problems[1].starts_with("a.log:6: ")) << read.problems[1];
}

TEST_F(ReadLogs, AScannerThatHangsUpsideDownTurnsTheOtherWay) {
  Write("a.log", kLog);
  Ask("a.log");
  const Eigen::AngleAxisd turned(1, Eigen::Vector3d::UnitZ());
  site_.sensors[0].robot_from_sensor.rotation =
      turned * Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX());
  const ScanLog log = Read().logs.at(0);
  EXPECT_NEAR(log.robot_from_laser.heading_rad, 1, 1e-12);
  EXPECT_EQ(log.scans[0].value, Eigen::Vector3d(M_PI / 2, -M_PI / 2, 80));
}

TEST_F(ReadLogs, ARobotThatTurnedHasTheLastPoseOfEachLine) {
  Write("a.log", kLog);
  Ask("a.log").turn = true;
  const ScanLogs read = Read();
  const auto& poses = read.logs[0].odometry_from_robot;
  ASSERT_EQ(poses.size(), read.logs[0].scans.size());
  EXPECT_EQ(poses[0].translation, Eigen::Vector2d(1, 2));
  EXPECT_EQ(poses[0].heading_rad, 0.5);
  EXPECT_EQ(poses[1].translation, Eigen::Vector2d(1.25, 2));
  EXPECT_NEAR(poses[1].heading_rad, 7.5 - 2 * M_PI, 1e-12);
}

TEST_F(ReadLogs, ALogMayBeGzippedOrTextOrLieElsewhere) {
  const std::string gzipped = (folder_.Path() / "b.log.gz").string();
  gzFile file = gzopen(gzipped.c_str(), "wb");
  gzputs(file, "RLASER 1 3 9 9 9 1 2 0.5 10.5 host 10.5\n");
  gzclose(file);
  Write("c.txt", "# seconds and ranges\n7.5 1 2 3\n");
  ScanQueryConfig& query = Ask("../../b.log.gz");
  query.message = "RLASER";
  query.near_m = {1, -2};
  query.near_radius_m = 4;
  Ask("c.txt").format = "text";
  const ScanLogs read = Read();
  ASSERT_EQ(read.logs.size(), 2U);
  EXPECT_EQ(read.logs[0].scans.at(0).ranges_m, std::vector<float>{3});
  ASSERT_TRUE(read.logs[0].rough_position.has_value());
  EXPECT_EQ(read.logs[0].rough_position->point_in_map, Eigen::Vector2d(1, -2));
  EXPECT_EQ(read.logs[0].rough_position->radius_m, 4);
  EXPECT_EQ(read.logs[1].scans.at(0).time_ns, 7'500'000'000);
  EXPECT_EQ(read.logs[1].scans.at(0).ranges_m, (std::vector<float>{1, 2, 3}));
}

TEST_F(ReadLogs, WhatAScannerSeesOfItsRobotIsNotMeasured) {
  site_.sensors[0].blind_deg = {80, 100};
  site_.sensors[0].min_range_m = 1.2;
  Write("c.txt", "7.5 1 2 3\n");
  Ask("c.txt").format = "text";
  EXPECT_EQ(Read().logs.at(0).scans.at(0).ranges_m, (std::vector<float>{-1, 2, -1}));
}

TEST_F(ReadLogs, ALogMayBeATable) {
  Write("d.csv", "r0, t_ns, r1\n 1, 7500000000, 2\n3,7600000000\n3,7700000000,-1\n");
  ScanQueryConfig& query = Ask("d.csv");
  query.format = "csv";
  query.columns = "t_ns";
  query.time_unit = "ns";
  const ScanLogs read = Read();
  ASSERT_EQ(read.logs[0].scans.size(), 2U);
  EXPECT_EQ(read.logs[0].scans[0].time_ns, 7'500'000'000);
  EXPECT_EQ(read.logs[0].scans[0].ranges_m, (std::vector<float>{1, 2}));
  EXPECT_EQ(read.logs[0].scans[1].ranges_m, (std::vector<float>{3, 0}));
  EXPECT_EQ(read.problems.at(0), "d.csv:3: 2 fields, expected 3");
}

TEST_F(ReadLogs, TheRangeOfNoHitIsFoundAsInARecording) {
  std::string log;
  for (int i = 0; i < 3; ++i) {
    log += fmt::format("{}", i);
    for (int k = 0; k < 4; ++k) log += " 1.5 2.25";
    for (int k = 0; k < 64; ++k) log += " 3.9";
    log += '\n';
  }
  Write("a.txt", log);
  Ask("a.txt").format = "text";
  site_.sensors[0].angle_step_deg = 2;
  EXPECT_EQ(Read().logs[0].scans[0].value[2], 3.9F);
  site_.sensors[0].max_range_m = 8;
  EXPECT_EQ(Read().logs[0].scans[0].value[2], 8);
}

TEST_F(ReadLogs, LinesWithoutTimesFollowEachOtherAtTheirRate) {
  Write("a.log", "FLASER 1 3 9 9 9 1 2 0.5\nFLASER 1 3 9 9 9 1 2 0.5\n");
  Ask("a.log").rate_hz = 4;
  EXPECT_EQ(Read().logs[0].scans.at(1).time_ns, 250'000'000);
}

TEST_F(ReadLogs, ALogWithoutScansIsAnErrorNamingFileAndRemedy) {
  Write("a.log", "ODOM 1 2 3 0 0 0 10.5 host 10.5\n");
  Ask("a.log");
  NIGHTMAP_EXPECT_ERROR(DataError,
                        Read(),
                        "lab/a.log: holds no scan: correct `scans`, `format` or `message` in "
                        "s.toml:9");
  Write("a.log", "FLASER 2 1\n");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(), "lab/a.log: holds no scan (a.log:1: ");
  Write("a.log", "");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(), "holds no scan");
  site_.scan_queries[0].scans = "missing.log";
  NIGHTMAP_EXPECT_ERROR(DataError, Read(), "lab/missing.log: no such file");
}

TEST_F(ReadLogs, TooManyBadLinesAreAnError) {
  Write("a.log", kLog);
  Ask("a.log");
  NIGHTMAP_EXPECT_ERROR(
      DataError, Read(0.2), "lab/a.log: 2 of 4 lines are no scan (the first: a.log:4: ");
  NIGHTMAP_EXPECT_ERROR(DataError,
                        Read(0.2),
                        "more than max_failed_ratio = 0.2: repair the file or correct s.toml:9");
}

}  // namespace nightmap::read_logs_test
