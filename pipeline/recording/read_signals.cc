// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/read_signals.h"

#include <algorithm>
#include <map>

#include "pipeline/base/plain_text.h"
#include "pipeline/recording/common_time.h"
#include "pipeline/recording/line_clock.h"
#include "pipeline/recording/odometry_units.h"
#include "pipeline/recording/scan_ranges.h"
#include "pipeline/recording/signal_file.h"
#include "pipeline/recording/sum_up_odometry.h"

namespace nightmap {
namespace {

// For messages.
std::filesystem::path FirstFileOf(int sensor_idx,
                                  const SiteConfig& site,
                                  const std::filesystem::path& data_root) {
  const auto first = std::ranges::find(site.signals, sensor_idx, &SignalConfig::sensor_idx);
  return first == site.signals.end() ? data_root : data_root / site.root / first->file;
}

// Files that are one, read for several sensors, or for several kinds of lines, have one clock.
void PutClocksRight(std::vector<SignalFile>* files) {
  std::map<std::string, std::vector<SignalFile*>> of_clock;
  for (SignalFile& file : *files) {
    if (!file.ClockName().empty()) of_clock[file.ClockName()].push_back(&file);
  }
  for (const auto& [name, sharing] : of_clock) {
    std::map<std::string, int> kinds;
    std::vector<StampedLine> stamps;
    for (const SignalFile* file : sharing) {
      const int kind = kinds.emplace(file->Message(), kinds.size()).first->second;
      file->AppendStamps(kind, &stamps);
    }
    const LineClock clock(std::move(stamps));
    for (SignalFile* file : sharing) file->TakeTimes(clock);
  }
}

}  // namespace

SensorSignals ReadSensorSignals(const SiteConfig& site,
                                const std::filesystem::path& data_root,
                                double max_failed_ratio) {
  SensorSignals result;
  result.num_in_line_order.resize(site.sensors.size());
  result.found_in_scans.resize(site.sensors.size());
  for (const SensorConfig& sensor : site.sensors) {
    result.signals.push_back(
        {sensor.kind, sensor.id, sensor.robot_from_sensor, {}, sensor.scan_duration_s});
  }
  std::vector<SignalFile> files;
  for (const SignalConfig& config : site.signals) {
    const std::filesystem::path file =
        (std::filesystem::path(site.root) / config.file).lexically_normal();
    files.emplace_back(config,
                       site.sensors[static_cast<std::size_t>(config.sensor_idx)],
                       data_root / file,
                       AsText(file.generic_string()));
    files.back().Read();
  }
  PutClocksRight(&files);
  for (std::size_t i = 0; i < files.size(); ++i) {
    const auto idx = static_cast<std::size_t>(site.signals[i].sensor_idx);
    SignalFile& file = files[i];
    Signal& signal = result.signals[idx];
    file.AppendTo(&signal.samples);
    file.Check(max_failed_ratio);
    if (signal.kind == SignalKind::kScan) DemandMetres(signal, file.Path());
    result.num_in_line_order[idx] += file.NumInLineOrder();
    result.problems.insert(result.problems.end(), file.Problems().begin(), file.Problems().end());
  }
  for (std::size_t i = 0; i < site.sensors.size(); ++i) {
    const SensorConfig& sensor = site.sensors[i];
    std::vector<SignalSample>* samples = &result.signals[i].samples;
    if (sensor.kind == SignalKind::kOdometry) {
      SumUpOdometry(sensor, samples);
      DemandUnits(sensor, *samples, FirstFileOf(static_cast<int>(i), site, data_root));
    }
    if (sensor.kind != SignalKind::kScan) continue;
    result.found_in_scans[i] = FinishScans(sensor, samples);
  }
  result.apart = DemandCommonTime(site, result.signals);
  return result;
}

}  // namespace nightmap
