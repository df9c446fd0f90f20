// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/read_signals.h"

#include <cmath>

#include "pipeline/io/data_paths.h"
#include "pipeline/recording/scan_ranges.h"
#include "pipeline/recording/signal_file.h"

namespace nightmap {
namespace {

// Accumulates measured motions into poses. The robot turns evenly while it drives, so it moves
// along the mean of its headings.
void SumUpOdometry(const SensorConfig& sensor, std::vector<SignalSample>* samples) {
  if (sensor.measures == "pose") return;
  Eigen::Vector3d pose = Eigen::Vector3d::Zero();
  Eigen::Vector2d last_ticks =
      samples->empty() ? Eigen::Vector2d(0, 0) : Eigen::Vector2d(samples->front().value.head<2>());
  for (SignalSample& sample : *samples) {
    Eigen::Vector2d motion = sample.value.head<2>();  // distance, heading change
    if (sensor.measures == "ticks") {
      const Eigen::Vector2d way_m = sensor.m_per_tick * (motion - last_ticks);
      last_ticks = motion;
      motion = {way_m.mean(), (way_m[1] - way_m[0]) / sensor.wheel_base_m};
    }
    const double heading_rad = pose[2] + motion[1] / 2;
    pose += Eigen::Vector3d(
        motion[0] * std::cos(heading_rad), motion[0] * std::sin(heading_rad), motion[1]);
    sample.value = pose;
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
  for (const SignalConfig& config : site.signals) {
    const auto idx = static_cast<std::size_t>(config.sensor_idx);
    const std::filesystem::path file =
        (std::filesystem::path(site.root) / config.file).lexically_normal();
    SignalFile log(config, site.sensors[idx], data_root / file, AsText(file.generic_string()));
    log.Read();
    log.AppendTo(&result.signals[idx].samples);
    log.Check(max_failed_ratio);
    const Signal& signal = result.signals[idx];
    if (signal.kind == SignalKind::kScan) DemandMetres(signal, data_root / file);
    result.num_in_line_order[idx] += log.NumInLineOrder();
    result.problems.insert(result.problems.end(), log.Problems().begin(), log.Problems().end());
  }
  for (std::size_t i = 0; i < site.sensors.size(); ++i) {
    const SensorConfig& sensor = site.sensors[i];
    std::vector<SignalSample>* samples = &result.signals[i].samples;
    if (sensor.kind == SignalKind::kOdometry) SumUpOdometry(sensor, samples);
    if (sensor.kind != SignalKind::kScan) continue;
    result.found_in_scans[i] = FinishScans(sensor, samples);
  }
  return result;
}

}  // namespace nightmap
