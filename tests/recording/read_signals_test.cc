// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/read_signals.h"

#include <sys/stat.h>
#include <zlib.h>

#include <algorithm>
#include <numbers>

#include "pipeline/base/error.h"
#include "pipeline/base/random.h"
#include "pipeline/recording/wheel_motion.h"
#include "tests/test_data.h"

namespace nightmap::read_signals_test {

std::string Repeated(const std::string& text, int count) {
  std::string result;
  for (int i = 0; i < count; ++i) result += text;
  return result;
}

class ReadSignalsTest : public testing::Test {
 protected:
  ReadSignalsTest() {
    site_.root = "site";
    site_.sensors.emplace_back().id = "imu";
    Signal("log.txt", "text");
  }

  SensorConfig& Sensor() { return site_.sensors[0]; }
  SignalConfig& Signal(const std::string& file, const std::string& format) {
    site_.signals.resize(1);
    site_.signals[0].file = file;
    site_.signals[0].format = format;
    site_.signals[0].source = "site.toml:9";
    return site_.signals[0];
  }
  // Lines of a log in CARMEN's format.
  void Carmen(SignalKind kind, const std::string& message) {
    Sensor().kind = kind;
    Signal("a.log", "carmen").message = message;
  }
  void Ticks() {
    Sensor().kind = SignalKind::kOdometry;
    Sensor().measures = "ticks";
    Sensor().m_per_tick = 0.001;
    Sensor().wheel_base_m = 0.5;
  }
  // A second sensor, whose odometry is in the same log.
  void AddWheels() {
    site_.sensors.emplace_back().id = "wheels";
    site_.sensors[1].kind = SignalKind::kOdometry;
    site_.signals.push_back(site_.signals[0]);
    site_.signals[1].message = "ODOM";
    site_.signals[1].sensor_idx = 1;
  }
  void ExpectProblems(const SensorSignals& read, const std::vector<std::string>& texts) const {
    ASSERT_EQ(read.problems.size(), texts.size());
    for (std::size_t i = 0; i < texts.size(); ++i) {
      EXPECT_THAT(read.problems[i], testing::HasSubstr(texts[i]));
    }
  }
  SensorSignals Read(const std::string& text, double max_failed_ratio = 0.5) {
    folder_.Write("site/" + site_.signals[0].file, text);
    return ReadSensorSignals(site_, folder_.Path(), max_failed_ratio);
  }
  std::vector<SignalSample> Samples(const std::string& text) {
    return Read(text, 0).signals.at(0).samples;
  }
  void ExpectLast(const std::string& text, const Eigen::Vector3d& value, double tolerance) {
    EXPECT_LT((Samples(text).back().value - value).norm(), tolerance) << text;
  }
  // Whatever the bytes that `damage` makes of the text, they are read or refused. Returns the
  // number of those that are read.
  template <typename Damage>
  int NumReadOfDamaged(const std::string& text, std::size_t max_samples, const Damage& damage) {
    int num_read = 0;
    for (int i = 0; i < 300; ++i) {
      std::string damaged = text;
      damage(&damaged);
      try {
        EXPECT_LE(Read(damaged, 1).signals[0].samples.size(), max_samples);
        ++num_read;
      } catch (const DataError& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr(site_.signals[0].file));
      } catch (const UsageError& error) {  // of the header
        EXPECT_EQ(site_.signals[0].format, "csv");
        EXPECT_THAT(error.what(), testing::HasSubstr("site.toml:9"));
      }
    }
    return num_read;
  }

  TemporaryFolder folder_;
  SiteConfig site_;
};

TEST_F(ReadSignalsTest, AccelerationsOfTum) {
  site_.signals[0].time_offset_s = 1;
  const auto samples = Samples("# t ax ay az\n0.5 0 -9.81 0.1\n\n0.6 1e0 0 0\r\n");
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples[0].time_ns, 1'500'000'000);
  EXPECT_EQ(samples[0].value, Eigen::Vector3d(0, -9.81, 0.1));
  EXPECT_EQ(samples[1].value.x(), 1);
}

TEST_F(ReadSignalsTest, LinesThatAreNoSampleAreLeftOutAndNamed) {
  const auto read =
      Read("0.5 0 0 1\n0.6 0 nan 1\n0.7 0 0\n0.8 0 0 1e308\nx 0 0 1\n0.9 0 0 1\n", 0.8);
  EXPECT_EQ(read.signals[0].samples.size(), 2u);
  ExpectProblems(read,
                 {"",
                  "log.txt:3: 2 words, expected 3",
                  "log.txt:4: an acceleration, which is in m/s2",
                  "log.txt:5: 'x' is not a time"});
  EXPECT_EQ(read.problems[0], "site/log.txt:2: 'nan' is not a finite number");
  NIGHTMAP_EXPECT_ERROR(DataError,
                        Read("0.5 0 0 1\n0.6 0 nan 1\n0.7 0 0\n", 0.5),
                        "2 of 3 lines are no sample in order (the first: site/log.txt:2");
  NIGHTMAP_EXPECT_ERROR(DataError, Read("# none\n"), "holds no sample of acceleration: correct");
  NIGHTMAP_EXPECT_ERROR(
      DataError, Read("a\n", 1), "holds no sample of acceleration (site/log.txt:1");
}

TEST_F(ReadSignalsTest, TimeThatGoesBackwardsIsLeftOutOrSorted) {
  const std::string text = "1 0 0 1\n3 0 0 3\n2 0 0 2\n3 0 0 4\n4 0 0 5\n";
  const auto read = Read(text);
  EXPECT_EQ(read.signals[0].samples.size(), 3u);
  EXPECT_THAT(read.problems.at(0),
              testing::HasSubstr("log.txt:3: time 2.000000 s is not after 3.000000 s"));
  NIGHTMAP_EXPECT_ERROR(DataError, Read(text, 0.1), "set sort = true");
  site_.signals[0].sort = true;
  const auto sorted = Read(text);
  ASSERT_EQ(sorted.signals[0].samples.size(), 4u);
  EXPECT_EQ(sorted.signals[0].samples[1].value.z(), 2);
  EXPECT_THAT(sorted.problems.at(0), testing::HasSubstr("log.txt:4: time 3.000000 s"));
  site_.signals[0].time_offset_s = 2e9;
  NIGHTMAP_EXPECT_ERROR(DataError, Read("4.5e9 0 0 1\n"), "out of range");
}

TEST_F(ReadSignalsTest, SeveralFilesOfASensorFollowEachOther) {
  folder_.Write("site/a.txt", "1 0 0 1\n2 0 0 2\n");
  folder_.Write("site/b.txt", "3 0 0 3\n");
  site_.signals.push_back(site_.signals[0]);
  site_.signals[0].file = "a.txt";
  site_.signals[1].file = "b.txt";
  const auto read = ReadSensorSignals(site_, folder_.Path(), 0);
  EXPECT_EQ(read.signals.at(0).samples.size(), 3u);
  std::swap(site_.signals[0], site_.signals[1]);
  NIGHTMAP_EXPECT_ERROR(DataError, ReadSensorSignals(site_, folder_.Path(), 0), "a.txt: 2 of 2");
}

TEST_F(ReadSignalsTest, ColumnsOfATable) {
  Sensor().kind = SignalKind::kOdometry;
  Signal("poses.csv", "csv").columns = "stamp,x_raw,y_raw,th";
  const auto samples = Samples("th,stamp,x,y_raw,x_raw\n0.1,5.5,9,2,3\n0.2,6,9,2,4\n");
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples[0].time_ns, 5'500'000'000);
  EXPECT_EQ(samples[0].value, Eigen::Vector3d(3, 2, 0.1));
  NIGHTMAP_EXPECT_ERROR(UsageError, Read("stamp,x\n1,2\n"), "no column 'x_raw', it has: stamp,x");
  EXPECT_THAT(Read("stamp,x_raw,y_raw,th\n1,2,3,4\n2,3\n").problems.at(0),
              testing::HasSubstr("poses.csv:3: 2 fields, expected 4"));
  site_.signals[0].columns = "t_ns,x,y,a";
  site_.signals[0].time_unit = "ns";  // as the config has it of such a name
  EXPECT_EQ(Samples("t_ns,x,y,a\n1305031102175304000,0,0,0\n")[0].time_ns, 1305031102175304000);
}

TEST_F(ReadSignalsTest, TimesOfOtherUnitsAreTheSame) {
  site_.signals[0].time_unit = "ns";
  EXPECT_EQ(Samples("1305031102175304003 0 0 1\n")[0].time_ns, 1305031102175304003);
  site_.signals[0].time_unit = "us";
  EXPECT_EQ(Samples("1305031102175304 0 0 1\n")[0].time_ns, 1305031102175304000);
  Sensor().kind = SignalKind::kOdometry;
  SignalConfig& table = Signal("poses.csv", "csv");
  table.columns = "stamp,x,y,th";
  table.time_unit = "ms";
  EXPECT_EQ(Samples("stamp,x,y,th\n1305031102175,1,2,0\n")[0].time_ns, 1305031102175000000);
}

TEST_F(ReadSignalsTest, TimesThatCannotBeSecondsNameTheirUnit) {
  const auto log = [](std::int64_t start, std::int64_t step) {
    std::string text;
    for (std::int64_t i = 0; i < 12; ++i) text += fmt::format("{} 0 0 1\n", start + i * step);
    return text;
  };
  NIGHTMAP_EXPECT_ERROR(DataError,
                        Read(log(1305031102175304003, 5'000'000)),
                        "log.txt: its times cannot be in seconds, they look like ns: write "
                        "time_unit = \"ns\" in the table at site.toml:9");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(log(0, 5)), "time_unit = \"ms\"");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(log(0, 5000)), "time_unit = \"us\"");
  Sensor().kind = SignalKind::kOdometry;
  EXPECT_EQ(Samples(log(0, 5)).size(), 12u);  // odometry may be that slow
  NIGHTMAP_EXPECT_ERROR(DataError, Read(log(0, 20)), "time_unit = \"ms\"");
  site_.signals[0].time_unit = "s";
  EXPECT_EQ(Samples(log(0, 20)).size(), 12u);
}

TEST_F(ReadSignalsTest, OdometryOfMotionsAndTicksIsSummedUp) {
  Sensor().kind = SignalKind::kOdometry;
  Sensor().measures = "motion";
  const double quarter = std::numbers::pi / 2;
  // A quarter of a circle of radius 1 in small steps, then 2 m on.
  std::string text = "0 0 0\n";
  constexpr int kSteps = 1000;
  for (int i = 1; i <= kSteps; ++i) {
    text += fmt::format("{} {:.15g} {:.15g}\n", i, quarter / kSteps, quarter / kSteps);
  }
  ExpectLast(text + "2000 2 0\n", {1, 3, quarter}, 1e-6);
  // The same circle by the counts of two wheels 0.5 m apart, from any count on.
  Ticks();
  text = "0 -70 1000000\n";
  for (int i = 1; i <= kSteps; ++i) {
    const double share = quarter * i / kSteps / Sensor().m_per_tick;
    text += fmt::format("{} {:.9f} {:.9f}\n", i, -70 + 0.75 * share, 1000000 + 1.25 * share);
  }
  ExpectLast(text, {1, 1, quarter}, 1e-6);
}

constexpr const char* kFlaser = "FLASER 3 1.5 2 81.9 1 2 3 4 5 6 10.5 host 10.5\n";

TEST_F(ReadSignalsTest, CarmenScans) {
  Carmen(SignalKind::kScan, "FLASER");
  Sensor().max_range_m = 81.8;
  const auto samples = Samples(std::string("# c\nPARAM x 1 2 h 3\nODOM junk\n") + kFlaser);
  ASSERT_EQ(samples.size(), 1u);
  EXPECT_EQ(samples[0].time_ns, 10'500'000'000);
  EXPECT_EQ(samples[0].ranges_m, (std::vector<float>{1.5f, 2.0f, 81.9f}));
  const double deg = std::numbers::pi / 180;
  EXPECT_LT((samples[0].value - Eigen::Vector3d(-90 * deg, 60 * deg, 81.8F)).norm(), 1e-12);
  Sensor().kind = SignalKind::kOdometry;
  EXPECT_EQ(Samples(kFlaser)[0].value, Eigen::Vector3d(4, 5, 6));
  Signal("a.log", "carmen").message = "ODOM";
  const auto odometry = Samples("ODOM 1 2 3 0.5 0.1 0 7.25 host 7.25\n");
  EXPECT_EQ(odometry[0].value, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(odometry[0].time_ns, 7'250'000'000);
}

TEST_F(ReadSignalsTest, CarmenScansThatSayTheirAngles) {
  Sensor().kind = SignalKind::kScan;
  const std::string head = " 0 -1.57 3.14 0.5 30 0.01 0 3 1 2 3 2 7 8 ";
  Signal("a.log", "carmen").message = "RAWLASER1";
  const auto raw = Samples("RAWLASER1" + head + "11 host 11\n");
  EXPECT_EQ(raw.at(0).value, Eigen::Vector3d(-1.57, 0.5, 30));
  EXPECT_EQ(raw[0].ranges_m, (std::vector<float>{1, 2, 3}));
  EXPECT_EQ(raw[0].time_ns, 11'000'000'000);
  Signal("a.log", "carmen").message = "ROBOTLASER1";
  const std::string robot = "ROBOTLASER1" + head + "1 2 3 4 5 6 0 0 0.1 0.1 0 12 host 12\n";
  EXPECT_EQ(Samples(robot).at(0).ranges_m.size(), 3u);
  EXPECT_EQ(Samples(robot)[0].time_ns, 12'000'000'000);
  Sensor().kind = SignalKind::kOdometry;
  EXPECT_EQ(Samples(robot).at(0).value, Eigen::Vector3d(4, 5, 6));
}

TEST_F(ReadSignalsTest, WhatTheSiteStatesOfAScannerHoldsBeforeWhatItsLinesDo) {
  Carmen(SignalKind::kScan, "RAWLASER1");
  const std::string line = "RAWLASER1 0 -1.57 3.14 0.5 30 0.01 0 3 1 2 3 0 11 host 11\n";
  Sensor().max_range_m = 8;
  EXPECT_EQ(Samples(line).at(0).value, Eigen::Vector3d(-1.57, 0.5, 8));
  Sensor().start_angle_deg = 0;
  EXPECT_EQ(Samples(line).at(0).value, Eigen::Vector3d(0, 0.5, 8));
  Sensor().angle_step_deg = -90;
  EXPECT_EQ(Samples(line).at(0).value[1], -std::numbers::pi / 2);
}

TEST_F(ReadSignalsTest, CarmenLinesThatLieAreLeftOut) {
  Carmen(SignalKind::kScan, "FLASER");
  const auto expect = [&](const std::string& line, const std::string& why) {
    const auto read = Read(line + '\n' + kFlaser, 1);
    EXPECT_EQ(read.signals[0].samples.size(), 1u) << line;
    ASSERT_EQ(read.problems.size(), 1u) << line;
    EXPECT_THAT(read.problems[0], testing::HasSubstr("site/a.log:1: " + why));
  };
  expect("FLASER", "1 words: the line is cut off");
  expect("FLASER 3 1 2 3 1 2 3 4 5 6 10.4 host", "13 words for 3 beams, expected 14");
  expect("FLASER 4 1 2 3 1 2 3 4 5 6 10.4 host 1", "14 words for 4 beams, expected 15");
  expect("FLASER 2 1 2 3 1 2 3 4 5 6 10.4 host 1", "14 words, expected 13");
  expect("FLASER 99999999999 1 2", "'99999999999' is no count of beams");
  expect("FLASER -3 1 2", "'-3' is no count of beams");
  expect("FLASER 0 1 2 3 4 5 6 10.4 host 1", "no beams");
  expect("FLASER 3 1 far 3 1 2 3 4 5 6 10.4 h 1", "'far' is not a finite number");
  expect("FLASER 3 1 1e999 3 1 2 3 4 5 6 10.4 h 1", "'1e999' is not a finite number");
  expect("FLASER 3 1 1e30 3 1 2 3 4 5 6 10.4 h 1", "a range is 1e30, beyond 1000000");
  expect("FLASER 3 1 2 3 1 2 3 4 5 6 soon h 1", "'soon' is not a time");
  Signal("a.log", "carmen").message = "ROBOTLASER1";
  NIGHTMAP_EXPECT_ERROR(DataError,
                        Read("ROBOTLASER1 0 -1.57 3.14 0.5 30 0.01 0 3 1 2 3 4000000000 1\n", 1),
                        "a.log:1: 14 words for 3 beams, expected 27");
}

std::string Flaser(const std::string& ranges, const std::string& time) {
  const auto count = std::ranges::count(ranges, ' ') + 1;
  return fmt::format("FLASER {} {} 1 2 3 4 5 6 {} host {}\n", count, ranges, time, time);
}

TEST_F(ReadSignalsTest, AClockThatWentBackALittleKeepsTheOrderOfLines) {
  const std::vector<std::string> stated = {
      "1", "2", "1.2", "2.0005", "1.9", "1.9", "0", "5", "1.5"};
  // The third and the fifth stay before and after the fourth; a line usually takes 0.8 s.
  const std::vector<std::int64_t> expected_us = {
      1'000'000, 2'000'000, 2'000'250, 2'000'500, 2'800'500, 5'000'000};
  std::string log, table = "t,x,y,a\n";
  for (const std::string& time : stated) {
    log += Flaser("1 2 3", time);
    table += time + ",1,2,3\n";
  }
  const auto expect = [&](const std::string& text) {
    const auto read = Read(text);
    std::vector<std::int64_t> times_us;
    for (const auto& sample : read.signals[0].samples) times_us.push_back(sample.time_ns / 1000);
    EXPECT_EQ(times_us, expected_us);
    EXPECT_EQ(read.num_in_line_order, std::vector<std::size_t>{2});
    ExpectProblems(read,
                   {"time 1.900000 s is not after 2.800500 s",
                    "time 0.000000 s is not after",
                    "time 1.500000 s is not after 5.000000 s"});
  };
  Carmen(SignalKind::kScan, "FLASER");
  expect(log);
  Carmen(SignalKind::kOdometry, "FLASER");
  expect(log);
  Signal("a.csv", "csv").columns = "t,x,y,a";
  expect(table);
  site_.signals[0].sort = true;
  EXPECT_EQ(Read(table).num_in_line_order, std::vector<std::size_t>{0});
}

TEST_F(ReadSignalsTest, LinesWithoutTimesFollowEachOtherAtTheirRate) {
  const std::string log =
      "FLASER 2 1 2 1 2 3 4 5 6\nODOM 1 2 3 0 0 0\nFLASER 2 1 2 1 2 3 4 5 7 0 host 0\n"
      "FLASER 2 1 2 1 2 3\nFLASER 2 1 2 1 2 3 4 5 8 0 host 0\nODOM 2 2 3 0 0 0 0 host 0\n";
  Carmen(SignalKind::kOdometry, "FLASER");
  NIGHTMAP_EXPECT_ERROR(DataError, Read(log, 0.2), "or rate_hz where they have no times");
  site_.signals[0].rate_hz = 4;
  site_.signals[0].time_offset_s = 100;
  const auto read = Read(log);
  ASSERT_EQ(read.signals[0].samples.size(), 3u);
  EXPECT_EQ(read.signals[0].samples[0].time_ns, 100'000'000'000);
  EXPECT_EQ(read.signals[0].samples[1].time_ns, 100'250'000'000);
  EXPECT_EQ(read.signals[0].samples[2].time_ns, 100'750'000'000);  // a line that is cut off counts
  EXPECT_EQ(read.signals[0].samples[2].value.z(), 8);
  EXPECT_THAT(read.problems.at(0), testing::HasSubstr("a.log:4: 7 words for 2 beams"));
  site_.signals[0].message = "ODOM";
  EXPECT_EQ(Samples(log).size(), 2u);
  site_.signals[0].message = "ROBOTLASER1";
  const std::string robot =
      "ROBOTLASER1 0 -1.57 3.14 0.5 30 0.01 0 1 1 0 1 2 3 4 5 6 0 0 0.1 0.1 0";
  EXPECT_EQ(Samples(robot + '\n')[0].value, Eigen::Vector3d(4, 5, 6));
}

// A log as a robot writes it is enough: scans and odometry are lines of one file.
TEST_F(ReadSignalsTest, TwoSensorsOfOneLog) {
  Sensor().kind = SignalKind::kScan;
  Signal("a.clf", "carmen").message = "RLASER";
  AddWheels();
  const auto read = Read(
      "ODOM 1 2 3 0 0 0 7 h 7\nRLASER 2 5 6 1 2 3 4 5 6 7.5 h 7.5\nODOM 2 2 3 0 0 0 8 h 8\n", 0);
  ASSERT_EQ(read.signals[0].samples.size(), 1u);
  EXPECT_EQ(read.signals[0].samples[0].ranges_m, (std::vector<float>{5, 6}));
  EXPECT_EQ(read.signals[0].samples[0].time_ns, 7'500'000'000);
  ASSERT_EQ(read.signals[1].samples.size(), 2u);
  EXPECT_EQ(read.signals[1].samples[1].value, Eigen::Vector3d(2, 2, 3));
}

// The wheels' clock is the scans': a line that is stamped early stays between those around it. The
// offset of one signal changes nothing of that.
TEST_F(ReadSignalsTest, SensorsOfOneLogShareItsClock) {
  Sensor().kind = SignalKind::kScan;
  Signal("a.clf", "carmen").message = "FLASER";
  AddWheels();
  site_.signals[1].time_offset_s = 1;
  std::string log;
  for (int i = 0; i < 40; ++i) {
    const double early_s = i >= 20 && i < 24 ? 0.7 : 0;
    const std::string odometry_s = fmt::format("{:.3f}", 100 + 0.1 * i - early_s);
    log += fmt::format("ODOM {} 0 0 0 0 0 {} h 0\n", 0.05 * i, odometry_s);
    log += Flaser("1 2 3", fmt::format("{:.3f}", 100.05 + 0.1 * i - early_s));
  }
  const auto read = Read(log, 0);
  const auto& [scans, wheels] = std::tie(read.signals[0].samples, read.signals[1].samples);
  ASSERT_EQ(scans.size(), 40u);
  ASSERT_EQ(wheels.size(), 40u);
  EXPECT_EQ(read.num_in_line_order, (std::vector<std::size_t>{4, 4}));
  for (std::size_t i = 0; i < 40; ++i) {
    const auto wheels_ns = wheels[i].time_ns - 1'000'000'000;
    EXPECT_NEAR(static_cast<double>(wheels_ns), 1e9 * (100 + 0.1 * static_cast<double>(i)), 1e7);
    EXPECT_NEAR(static_cast<double>(scans[i].time_ns - wheels_ns), 5e7, 1e7);
  }
}

TEST_F(ReadSignalsTest, CountersThatBeginAgainOrAreSwitchedOnAgain) {
  Ticks();
  const auto drive = [&](int period, int reset_at) {
    std::string text;
    int left = 0, right = 0;
    for (int i = 0; i < 200; ++i) {
      if (i == reset_at) left = right = 0;
      text += fmt::format("{} {} {}\n", 0.1 * i, left % period, right % period);
      left += 30;
      right += 31;
    }
    return Samples(text);
  };
  const auto straight = drive(1'000'000, -1);
  const auto wrapped = drive(4096 * 16, -1);
  const auto bytes = drive(256, -1);
  for (std::size_t i = 0; i < straight.size(); ++i) {
    EXPECT_LT((wrapped[i].value - straight[i].value).norm(), 1e-9);
    EXPECT_LT((bytes[i].value - straight[i].value).norm(), 1e-9);
  }
  const auto reset = drive(1'000'000, 12);
  for (std::size_t i = 1; i < reset.size(); ++i) {
    EXPECT_EQ(IsPossibleStep(reset[i - 1], reset[i]), i != 12) << i;
  }
}

TEST_F(ReadSignalsTest, UnitsOfOdometry) {
  Sensor().kind = SignalKind::kOdometry;
  Sensor().position_unit_m = 1e-3;
  Sensor().heading_unit_rad = std::numbers::pi / 180;
  ExpectLast("1 1500 -20 90\n", {1.5, -0.02, std::numbers::pi / 2}, 1e-12);
  ExpectLast("1 1500 -20 0 0 0 1\n", {1.5, -0.02, 0}, 1e-12);
  Sensor().measures = "motion";
  ExpectLast("1 1500 0\n2 0 90\n", {1.5, 0, std::numbers::pi / 2}, 1e-12);
  Sensor() = SensorConfig();
  Sensor().id = "wheels";
  Sensor().kind = SignalKind::kOdometry;
  std::string text;
  for (int i = 0; i < 100; ++i) text += fmt::format("{} {} 0 0\n", 0.2 * i, 100 * i);
  NIGHTMAP_EXPECT_ERROR(DataError,
                        Read(text),
                        "site/log.txt: by the odometry of \"wheels\" the robot usually drives "
                        "500 m/s, which no robot does: write position_unit = \"mm\" in its "
                        "[[sensor]], where that is 0.5 m/s, or \"cm\", where it is 5 m/s");
}

TEST_F(ReadSignalsTest, BlanksAroundFieldsOfATableDoNotCount) {
  Sensor().kind = SignalKind::kOdometry;
  Signal("poses.csv", "csv").columns = "time, x,y , heading";
  const auto samples = Samples("\xEF\xBB\xBFtime, x, y,\theading \r\n 1.5 , 2,3 , 0.5\r\n");
  ASSERT_EQ(samples.size(), 1u);
  EXPECT_EQ(samples[0].time_ns, 1'500'000'000);
  EXPECT_EQ(samples[0].value, Eigen::Vector3d(2, 3, 0.5));
}

TEST_F(ReadSignalsTest, ScansOfATableAreAllColumnsButTheTime) {
  Sensor().kind = SignalKind::kScan;
  Signal("scans.csv", "csv").columns = "time_s";
  const auto samples = Samples("r0,time_s,r1,r2\n1,10,2,3\n4, 11, -1,\n");
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples[0].ranges_m, (std::vector<float>{1, 2, 3}));
  EXPECT_EQ(samples[1].ranges_m, (std::vector<float>{4, 0, 0}));  // an empty field hit nothing
  EXPECT_EQ(samples[1].time_ns, 11'000'000'000);
}

TEST_F(ReadSignalsTest, OdometryMayHaveQuaternions) {
  Sensor().kind = SignalKind::kOdometry;
  Random random(3);
  std::string tum;
  std::vector<double> headings_rad;
  for (int i = 0; i < 20; ++i) {
    headings_rad.push_back(random.Uniform(-3, 3));
    tum += fmt::format("{} 1 2 9 0 0 {:.12f} {:.12f}\n",
                       i,
                       std::sin(headings_rad.back() / 2),
                       std::cos(headings_rad.back() / 2));
  }
  const auto samples = Samples(tum);
  ASSERT_EQ(samples.size(), headings_rad.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    EXPECT_LT((samples[i].value - Eigen::Vector3d(1, 2, headings_rad[i])).norm(), 1e-9);
  }
  EXPECT_THAT(Read(tum + "30 1 2 9 0 0 0 2\n").problems.at(0),
              testing::HasSubstr("log.txt:21: the quaternion qx qy qz qw has length 2, not 1"));
  EXPECT_THAT(Read(tum + "30 1 2 9 0\n").problems.at(0), testing::HasSubstr("4 words, expected 3"));
  Signal("poses.csv", "csv").columns = "t,x,y,qx,qy,qz,qw";
  ExpectLast("t,x,y,z,qw,qx,qy,qz\n1,5,6,0,0.8,0,0,0.6\n", {5, 6, 2 * std::asin(0.6)}, 1e-9);
}

TEST_F(ReadSignalsTest, RangesHaveTheUnitOfTheirScanner) {
  Sensor().kind = SignalKind::kScan;
  Sensor().id = "front";
  std::string log;
  for (int i = 0; i < 9; ++i) log += fmt::format("{} 1500 2250 65535 400 0 1500\n", i);
  NIGHTMAP_EXPECT_ERROR(DataError,
                        Read(log),
                        "log.txt: half of the ranges of \"front\" are 1500 or more, which are no "
                        "metres: write range_unit = \"mm\" in its [[sensor]], where that is 1.5 m");
  Sensor().range_unit_m = 1e-3;
  const auto scan = Samples(log).at(0);
  EXPECT_EQ(scan.ranges_m, (std::vector<float>{1.5F, 2.25F, 65.535F, 0.4F, 0, 1.5F}));
}

TEST_F(ReadSignalsTest, ARangeAsLargeAsTheLimitHitNothing) {
  Sensor().kind = SignalKind::kScan;
  for (const double limit_m : {8.19, 8.191, 10.1, 29.9, 81.83}) {
    Sensor().max_range_m = limit_m;
    const auto scan = Samples(fmt::format("1 {}", limit_m)).at(0);
    EXPECT_FALSE(scan.ranges_m[0] < scan.value[2]) << limit_m;
  }
}

TEST_F(ReadSignalsTest, TheRangeOfNoHitIsFoundWhereItIsNotStated) {
  Sensor().kind = SignalKind::kScan;
  Random random(5);
  std::string log;
  for (int i = 0; i < 50; ++i) {
    log += fmt::format("{}", i);
    for (int k = 0; k < 90; ++k) {
      log += random.Uniform() < 0.2 ? " 4.000" : fmt::format(" {:.3f}", random.Uniform(0.5, 3.9));
    }
    log += '\n';
  }
  const auto read = Read(log);
  EXPECT_EQ(read.found_in_scans.at(0).range_of_no_hit_m, 4.0F);
  for (const SignalSample& scan : read.signals[0].samples) EXPECT_EQ(scan.value[2], 4);
  Sensor().max_range_m = 30;
  EXPECT_EQ(Read(log).found_in_scans.at(0).range_of_no_hit_m, std::nullopt);
  EXPECT_EQ(Samples(log)[0].value[2], 30);
}

TEST_F(ReadSignalsTest, RangesThatAreNoNumberHitNothing) {
  Carmen(SignalKind::kScan, "FLASER");
  Sensor().max_range_m = 1e4;
  const auto scan = Samples(Flaser("1.5 nan -nan inf -inf NaN Infinity 9999 -1 20000", "1")).at(0);
  EXPECT_EQ(scan.ranges_m, (std::vector<float>{1.5, 0, 0, 1e4, 0, 0, 1e4, 9999, 0, 1e4}));
}

TEST_F(ReadSignalsTest, EachScanHasItsOwnNumberOfBeams) {
  Sensor().kind = SignalKind::kScan;
  std::string log;
  for (int i = 0; i < 20; ++i) {
    log += fmt::format("{}{}\n", i, Repeated(" 2", i % 2 == 0 ? 180 : 181));
  }
  const auto samples = Samples(log);
  ASSERT_EQ(samples.size(), 20u);
  for (const SignalSample& scan : samples) {  // SICK's, which has now and then a beam more
    EXPECT_NEAR(scan.value[1], std::numbers::pi / 180, 1e-12) << scan.ranges_m.size();
  }
}

TEST_F(ReadSignalsTest, ScansOfAnotherScannerAndLinesThatAreCutOffAreLeftOut) {
  Carmen(SignalKind::kScan, "FLASER");
  const std::string log =
      Flaser("1 2", "1") + Flaser("1 2 3", "2") + Flaser("3 2 1", "3") + Flaser("1 2 3 4", "4");
  const auto read = Read(log);
  EXPECT_EQ(read.signals[0].samples.size(), 2u);
  ExpectProblems(read,
                 {"a.log:1: 2 beams, most scans have about 3: give each", "a.log:4: 4 beams"});
  NIGHTMAP_EXPECT_ERROR(DataError, Read(log, 0.2), "a.log:1: 2 beams");
}

TEST_F(ReadSignalsTest, ScansThatAlwaysSpanTheCircleDoWhateverTheirNumberOfBeams) {
  Sensor().kind = SignalKind::kScan;
  Sensor().start_angle_deg = -180;
  Sensor().angle_step_deg = -1;
  const auto steps_deg = [&](const std::vector<int>& counts) {
    std::string log;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      log += fmt::format("{}{}\n", i, Repeated(" 2", counts[i]));
    }
    std::vector<double> result;
    for (const auto& scan : Samples(log)) result.push_back(scan.value[1] * 180 / M_PI);
    return result;
  };
  const auto turning = steps_deg({360, 350, 366, 371, 360, 345});
  EXPECT_NEAR(turning[0], -1, 1e-9);
  EXPECT_NEAR(turning[1], -360.0 / 350, 1e-9);
  EXPECT_NEAR(turning[3], -360.0 / 371, 1e-9);
  // A beam less is one that is missing; the first and the last beam may be the same.
  for (const double step_deg : steps_deg({360, 359, 361, 360, 359}))
    EXPECT_NEAR(step_deg, -1, 1e-9);
}

TEST_F(ReadSignalsTest, BeamsOfMoreThanACircleAreRefused) {
  Sensor().kind = SignalKind::kScan;
  Sensor().angle_step_deg = 1;
  NIGHTMAP_EXPECT_ERROR(
      DataError,
      Read("1" + Repeated(" 2", 720) + "\n"),
      "log.txt:1: 720 beams 1 deg apart span 719 deg, more than a circle: correct "
      "angle_step_deg, or, where a line holds more than ranges, as intensities");
}

TEST_F(ReadSignalsTest, GzippedLogsAreReadAndCutOnesRefused) {
  std::string text;
  for (int i = 0; i < 20000; ++i) text += fmt::format("{} 0 0 {}\n", i, i % 97);
  const auto path = folder_ / "site/log.gz";
  std::filesystem::create_directories(path.parent_path());
  gzFile file = gzopen(path.c_str(), "wb");
  ASSERT_EQ(gzwrite(file, text.data(), static_cast<unsigned>(text.size())),
            static_cast<int>(text.size()));
  gzclose(file);
  const std::string bytes = ReadBytes(path);
  Signal("log.gz", "text");
  EXPECT_EQ(Samples(bytes).size(), 20000u);
  NIGHTMAP_EXPECT_ERROR(
      DataError, Read(bytes.substr(0, bytes.size() / 2)), "log.gz: damaged or cut");
  std::string flipped = bytes;
  flipped[flipped.size() / 2] ^= 0x10;
  NIGHTMAP_EXPECT_ERROR(DataError, Read(flipped), "log.gz");
}

TEST_F(ReadSignalsTest, WhatIsNoLogIsRefused) {
  NIGHTMAP_EXPECT_ERROR(
      DataError, ReadSensorSignals(site_, folder_.Path(), 0), "log.txt: no such file");
  NIGHTMAP_EXPECT_ERROR(
      DataError, Read(std::string(3 << 20, 'x')), "log.txt:1: a line of more than");
  std::filesystem::remove(folder_ / "site/log.txt");
  ASSERT_EQ(mkfifo((folder_ / "site/log.txt").c_str(), 0600), 0);
  NIGHTMAP_EXPECT_ERROR(DataError, ReadSensorSignals(site_, folder_.Path(), 0), "log.txt: ");
}

TEST_F(ReadSignalsTest, DamageNeverCrashes) {
  Carmen(SignalKind::kScan, "FLASER");
  std::string log, table = "time, r0, r1, r2\n";
  for (int i = 0; i < 5; ++i) {
    log += fmt::format("FLASER 2 1 2 1 2 3 4 5 6 {} h 1\n", i);
    table += fmt::format("{}, 1, -1, inf\n", i);
  }
  Random random(7);
  const auto change = [&](int count, std::string* text) {
    for (int k = 0; k < count && !text->empty(); ++k) {
      (*text)[random.Index(text->size())] = static_cast<char>(random.Index(256));
    }
  };
  EXPECT_GT(NumReadOfDamaged(log, 6, [&](std::string* text) { change(4, text); }), 200);
  Sensor().start_angle_deg = -180;
  Signal("a.csv", "csv").columns = "time";
  const auto cut_and_change = [&](std::string* text) {
    text->resize(random.Index(text->size() + 1));
    change(2, text);
  };
  EXPECT_GT(NumReadOfDamaged(table, 7, cut_and_change), 50);
}

TEST(RealLogs, LaserLogsAreWhatTheyAreDocumentedToBe) {
  for (const auto& [name, num_scans, num_beams] :
       {std::tuple{"freiburg_079", 4791u, 360u}, std::tuple{"intel", 910u, 180u}}) {
    const SiteConfig site = ReadSiteConfig(std::string("configs/sites/") + name + ".toml");
    NIGHTMAP_REQUIRE_DATA(site.root);
    const auto read = ReadSensorSignals(site, TestDataPath(""), 0.01);
    ASSERT_EQ(read.signals.size(), 3u);
    for (const auto& signal : read.signals) EXPECT_EQ(signal.samples.size(), num_scans);
    EXPECT_EQ(read.signals[0].samples[0].ranges_m.size(), num_beams);
    EXPECT_EQ(read.num_in_line_order, std::vector<std::size_t>(3, num_beams == 180 ? 4 : 0));
    for (std::size_t i = 0; i < num_scans; ++i) {  // the table states the log's times
      EXPECT_EQ(read.signals[0].samples[i].time_ns, read.signals[1].samples[i].time_ns);
      EXPECT_EQ(read.signals[0].samples[i].time_ns, read.signals[2].samples[i].time_ns);
    }
  }
}

}  // namespace nightmap::read_signals_test
