// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/signals_io.h"

#include <fmt/format.h>

#include <algorithm>

#include "pipeline/io/hdf5_table.h"

namespace nightmap {
namespace {

constexpr char kSignalsFormat[] = "nightmap signals";
constexpr int kSignalsVersion = 1;

// As "value: x y (m) heading (rad)".
std::string UnitsText(const std::array<SignalValue, 3>& values) {
  std::string text = "value:";
  for (std::size_t i = 0; i < values.size(); ++i) {
    text += " " + values[i].name;
    const bool is_last = i + 1 == values.size() || values[i + 1].unit != values[i].unit;
    if (is_last) text += " (" + values[i].unit + ")";
  }
  return text;
}

std::string SensorName(std::size_t i) { return fmt::format("sensor_{}", i); }

constexpr auto kSamples = Hdf5Table<SignalSample>(
    Hdf5Column("time_ns", &SignalSample::time_ns),
    Hdf5Column("value", &SignalSample::value),
    Hdf5Lists(
        "range_offset", &SignalSample::ranges_m, Hdf5Table<float>(Hdf5Column("range_m", kItself))));

constexpr auto kSignals =
    Hdf5Table<Signal>(Hdf5Column("robot_from_sensor", &Signal::robot_from_sensor),
                      Hdf5Lists("sample_offset", &Signal::samples, kSamples));

// Files without it are of scans that are taken at once.
constexpr char kDurationName[] = "scan_duration_s";
constexpr auto kDurations =
    Hdf5Table<double>(Hdf5Column(kDurationName, kItself).Elements([](double duration_s) {
      return duration_s >= 0 && duration_s <= kMaxScanDuration_s;
    }));

void ReadDurations(const Hdf5Reader& file, std::vector<Signal>* signals) {
  if (!file.Has(kDurationName)) return;
  const auto durations_s = kDurations.Read(file);
  file.Demand(durations_s.size() == signals->size(), kDurationName);
  for (std::size_t i = 0; i < signals->size(); ++i) {
    (*signals)[i].scan_duration_s = durations_s[i];
  }
}

}  // namespace

void WriteSignals(const std::filesystem::path& path,
                  SignalKind kind,
                  const std::vector<Signal>& signals) {
  Hdf5Writer file(path,
                  kSignalsFormat,
                  kSignalsVersion,
                  "# made of the site config\n",
                  UnitsText(RowOf(kind).values));
  file.WriteText("kind", NameOf(kind));
  for (std::size_t i = 0; i < signals.size(); ++i) {
    file.WriteText(SensorName(i), signals[i].sensor_id);
  }
  kSignals.Write(signals, &file);
  const auto takes_time = [](const Signal& signal) { return signal.scan_duration_s != 0; };
  if (std::ranges::any_of(signals, takes_time)) {
    std::vector<double> durations_s;
    for (const Signal& signal : signals) durations_s.push_back(signal.scan_duration_s);
    kDurations.Write(durations_s, &file);
  }
  file.Close();
}

std::vector<Signal> ReadSignals(const std::filesystem::path& path, SignalKind kind) {
  const Hdf5Reader file(path, kSignalsFormat, kSignalsVersion);
  file.Demand(file.ReadText("kind") == NameOf(kind), "kind", "is another kind of signal");
  auto signals = kSignals.Read(file);
  ReadDurations(file, &signals);
  for (std::size_t i = 0; i < signals.size(); ++i) {
    signals[i].kind = kind;
    signals[i].sensor_id = file.ReadText(SensorName(i));
    const auto& samples = signals[i].samples;
    for (std::size_t k = 0; k < samples.size(); ++k) {
      file.Demand(
          samples[k].ranges_m.empty() || kind == SignalKind::kScan, "range_m", "is of scans only");
      file.Demand(
          k == 0 || samples[k - 1].time_ns < samples[k].time_ns, "time_ns", "does not increase");
    }
  }
  return signals;
}

}  // namespace nightmap
