// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_queries/read_logs.h"

#include <cmath>
#include <optional>

#include "pipeline/base/error.h"
#include "pipeline/io/text_file.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/recording/csv_columns.h"
#include "pipeline/recording/finish_scans.h"
#include "pipeline/recording/gzip_lines.h"
#include "pipeline/recording/read_sequence.h"
#include "pipeline/recording/read_signals.h"
#include "pipeline/recording/scan_points.h"
#include "pipeline/recording/time_unit.h"

namespace nightmap {
namespace {

using Words = std::vector<std::string_view>;

// Reads one log.
class LogOfScans {
 public:
  LogOfScans(const ScanQueryConfig& config, const SensorConfig& scanner)
      : config_(config), scanner_(scanner) {
    odometry_.kind = SignalKind::kOdometry;
  }

  void Read(const std::filesystem::path& path) {
    VisitLogLines(path, [&](int number, std::string_view line) {
      if (config_.format == "csv" && number == 1) {
        csv_.emplace(line, config_.columns, SignalKind::kScan, config_.source, path.string());
        return;
      }
      const Words words = SplitWords(line);
      if (words.empty() || words[0].starts_with('#')) return;
      if (config_.format == "carmen" && words[0] != config_.message) return;
      ++num_lines_;
      try {
        AddScan(csv_ ? csv_->FieldsOf(line) : words);
      } catch (const DataError& error) {
        problems_.push_back(fmt::format("{}:{}: {}", config_.scans, number, error.what()));
      }
    });
  }

  void Check(const std::filesystem::path& path, double max_failed_ratio) const {
    if (log_.scans.empty()) {
      throw DataError("{}: holds no scan{}: correct `scans`, `format` or `message` in {}",
                      path.string(),
                      problems_.empty() ? "" : " (" + problems_.front() + ")",
                      config_.source);
    }
    const double num_lines = static_cast<double>(num_lines_);
    if (static_cast<double>(problems_.size()) <= max_failed_ratio * num_lines) return;
    throw DataError(
        "{}: {} of {} lines are no scan (the first: {}), more than max_failed_ratio = {}: repair "
        "the file or correct {}",
        path.string(),
        problems_.size(),
        num_lines_,
        problems_.front(),
        max_failed_ratio,
        config_.source);
  }

  void AppendTo(ScanLogs* result) {
    FinishScans(scanner_, &log_.scans);
    log_.name = config_.scans;
    log_.source = config_.source;
    const ScannerFromAbove scanner = SeenFromAbove(scanner_.robot_from_sensor);
    log_.robot_from_laser = scanner.robot_from_laser;
    if (scanner.is_upside_down) {
      for (SignalSample& scan : log_.scans) scan.value.head<2>() *= -1;
    }
    log_.turn = config_.turn;
    if (!config_.near_m.empty()) {
      log_.rough_position =
          RoughPosition{{config_.near_m[0], config_.near_m[1]}, config_.near_radius_m};
    }
    result->logs.push_back(std::move(log_));
    result->problems.insert(result->problems.end(), problems_.begin(), problems_.end());
  }

 private:
  void AddScan(const Words& words) {
    SignalSample scan = config_.format == "carmen" ? CarmenScan(words) : TextScan(words);
    scan.time_ns = CheckedTime_ns(scan.time_ns);
    if (config_.turn) {
      const auto pose = ParseCarmenLine(odometry_, LineTime::kIgnored, words).value;
      log_.odometry_from_robot.push_back({WrapAngle_rad(pose[2]), pose.head<2>()});
    }
    log_.scans.push_back(std::move(scan));
  }

  // With a rate_hz the lines follow each other at it, whatever times they state.
  SignalSample CarmenScan(const Words& words) const {
    if (config_.rate_hz == 0) return ParseCarmenLine(scanner_, LineTime::kNeeded, words);
    SignalSample scan = ParseCarmenLine(scanner_, LineTime::kIgnored, words);
    scan.time_ns = std::llround(1e9 * static_cast<double>(num_lines_ - 1) / config_.rate_hz);
    return scan;
  }

  SignalSample TextScan(const Words& words) const {
    const std::int64_t time_ns = ParseTime_ns(words[0], UnitOf(config_.time_unit));
    return ParseValues(scanner_, time_ns, {words.begin() + 1, words.end()});
  }

  const ScanQueryConfig& config_;
  const SensorConfig& scanner_;
  SensorConfig odometry_;
  ScanLog log_;
  std::optional<CsvColumns> csv_;
  std::size_t num_lines_ = 0;
  std::vector<std::string> problems_;
};

}  // namespace

ScanLogs ReadScanLogs(const SiteConfig& site,
                      const std::filesystem::path& data_root,
                      double max_failed_ratio) {
  ScanLogs result;
  for (const ScanQueryConfig& config : site.scan_queries) {
    // Not normalized together with the data folder, because that may be a link, and `..` would then
    // lead out of its target.
    const auto path =
        data_root / (std::filesystem::path(site.root) / config.scans).lexically_normal();
    LogOfScans log(config, site.sensors[static_cast<std::size_t>(config.sensor_idx)]);
    log.Read(path);
    log.Check(path, max_failed_ratio);
    log.AppendTo(&result);
  }
  return result;
}

}  // namespace nightmap
