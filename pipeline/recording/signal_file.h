// SPDX-License-Identifier: Apache-2.0
// One file of samples of one sensor, for read_signals.h.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/recording/csv_columns.h"
#include "pipeline/recording/line_clock.h"
#include "pipeline/recording/site_config.h"
#include "pipeline/recording/time_unit.h"

namespace nightmap {

// Reads one file: parses its lines, then sorts them or puts their times right. All errors are those
// of ReadSensorSignals.
class SignalFile {
 public:
  // `name` is the file relative to the data folder, for messages about lines.
  SignalFile(const SignalConfig& config,
             const SensorConfig& sensor,
             std::filesystem::path path,
             std::string name)
      : config_(config), sensor_(sensor), path_(std::move(path)), name_(std::move(name)) {}

  void Read();
  // Names the clock that stamps the lines; files of one clock share a LineClock. Empty: the times
  // stay as they are.
  std::string ClockName() const;
  // Appends the lines that have a time, as lines of this kind.
  void AppendStamps(int kind, std::vector<StampedLine>* lines) const;
  void TakeTimes(const LineClock& clock);
  // Appends, once, the samples that are later than the existing ones.
  void AppendTo(std::vector<SignalSample>* samples);
  // After both, throws where the file as a whole is not what the config says.
  void Check(double max_failed_ratio) const;

  const std::vector<std::string>& Problems() const { return problems_; }
  const std::filesystem::path& Path() const { return path_; }
  const std::string& Message() const { return config_.message; }
  std::size_t NumInLineOrder() const { return num_in_line_order_; }

 private:
  using Words = std::vector<std::string_view>;
  struct LoggedSample {
    int line = 0;
    SignalSample sample;
  };

  void Skip(int line, const std::string& why);
  void LeaveOutOtherScans();
  std::int64_t Offset_ns() const;
  void ReadLine(int number, std::string_view line);
  SignalSample CarmenSample(const Words& words) const;
  void ReadCsvLine(int number, std::string_view line);
  std::int64_t LineTime_ns(std::string_view text);
  void CheckUnit() const;
  void Add(int number, SignalSample sample);

  const SignalConfig& config_;
  const SensorConfig& sensor_;
  std::filesystem::path path_;
  std::string name_;
  std::size_t num_lines_ = 0;
  std::size_t num_in_line_order_ = 0;
  std::optional<CsvColumns> csv_;
  TimeUnit unit_ = UnitOf(config_.time_unit);
  std::vector<double> times_;  // as written
  std::vector<LoggedSample> samples_;
  std::vector<StampedLine> stamps_;  // without offset
  std::vector<std::string> problems_;
};

}  // namespace nightmap
