// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/signals_io.h"

#include <fmt/format.h>

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/io/hdf5_file.h"
#include "pipeline/io/pose_arrays.h"

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

// All samples of the file, sensor after sensor.
std::vector<SignalSample> ReadSamples(const Hdf5Reader& file, SignalKind kind) {
  const auto time_ns = file.ReadList<std::int64_t>("time_ns");
  const auto value = file.Read<double>("value", 3);
  const auto range_m = file.ReadList<float>("range_m");
  file.Demand(value.rows == time_ns.size(), "value");
  file.Demand(range_m.empty() || kind == SignalKind::kScan, "range_m", "is of scans only");
  const auto offsets = file.ReadOffsets("range_offset", time_ns.size(), range_m.size());
  std::vector<SignalSample> samples(time_ns.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].time_ns = time_ns[i];
    samples[i].value = Eigen::Map<const Eigen::Vector3d>(&value.values[3 * i]);
    samples[i].ranges_m.assign(range_m.begin() + static_cast<std::ptrdiff_t>(offsets[i]),
                               range_m.begin() + static_cast<std::ptrdiff_t>(offsets[i + 1]));
  }
  return samples;
}

// One for each sensor. Files without it are of scans that are taken at once.
std::vector<double> ReadDurations_s(const Hdf5Reader& file, std::size_t count) {
  const std::string name = "scan_duration_s";
  if (!file.Has(name)) return std::vector<double>(count);
  const auto durations_s = file.ReadList<double>(name);
  file.Demand(durations_s.size() == count, name);
  for (const double duration_s : durations_s) {
    file.Demand(duration_s >= 0 && duration_s <= kMaxScanDuration_s, name);
  }
  return durations_s;
}

}  // namespace

void WriteSignals(const std::filesystem::path& path,
                  SignalKind kind,
                  const std::vector<Signal>& signals) {
  Array<double> pose{0, 7, {}}, value{0, 3, {}};
  std::vector<std::int64_t> sample_offset = {0}, time_ns, range_offset = {0};
  std::vector<float> range_m;
  std::vector<double> duration_s;
  Hdf5Writer file(path,
                  kSignalsFormat,
                  kSignalsVersion,
                  "# made of the site config\n",
                  UnitsText(RowOf(kind).values));
  file.WriteText("kind", NameOf(kind));
  for (std::size_t i = 0; i < signals.size(); ++i) {
    file.WriteText(SensorName(i), signals[i].sensor_id);
    AppendPose(signals[i].robot_from_sensor, &pose);
    duration_s.push_back(signals[i].scan_duration_s);
    for (const SignalSample& sample : signals[i].samples) {
      time_ns.push_back(sample.time_ns);
      value.values.insert(value.values.end(), sample.value.begin(), sample.value.end());
      ++value.rows;
      range_m.insert(range_m.end(), sample.ranges_m.begin(), sample.ranges_m.end());
      range_offset.push_back(static_cast<std::int64_t>(range_m.size()));
    }
    sample_offset.push_back(static_cast<std::int64_t>(time_ns.size()));
  }
  file.Write("robot_from_sensor", pose);
  file.WriteList("sample_offset", sample_offset);
  file.WriteList("time_ns", time_ns);
  file.Write("value", value);
  file.WriteList("range_offset", range_offset);
  file.WriteList("range_m", range_m);
  if (std::ranges::any_of(duration_s, [](double duration) { return duration != 0; })) {
    file.WriteList("scan_duration_s", duration_s);
  }
  file.Close();
}

std::vector<Signal> ReadSignals(const std::filesystem::path& path, SignalKind kind) {
  const Hdf5Reader file(path, kSignalsFormat, kSignalsVersion);
  file.Demand(file.ReadText("kind") == NameOf(kind), "kind", "is another kind of signal");
  const auto pose = file.Read<double>("robot_from_sensor", 7);
  auto samples = ReadSamples(file, kind);
  const auto offsets = file.ReadOffsets("sample_offset", pose.rows, samples.size());
  const auto durations_s = ReadDurations_s(file, pose.rows);
  std::vector<Signal> signals;
  for (std::size_t i = 0; i < pose.rows; ++i) {
    Signal& signal = signals.emplace_back();
    signal.kind = kind;
    signal.sensor_id = file.ReadText(SensorName(i));
    signal.robot_from_sensor = PoseAt(pose, i, path);
    signal.scan_duration_s = durations_s[i];
    for (std::size_t k = offsets[i]; k < offsets[i + 1]; ++k) {
      file.Demand(k == offsets[i] || samples[k - 1].time_ns < samples[k].time_ns,
                  "time_ns",
                  "does not increase");
      signal.samples.push_back(std::move(samples[k]));
    }
  }
  return signals;
}

}  // namespace nightmap
