// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/read_signals.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "pipeline/base/error.h"
#include "pipeline/io/csv.h"
#include "pipeline/io/data_paths.h"
#include "pipeline/io/text_file.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/recording/gzip_lines.h"
#include "pipeline/recording/read_sequence.h"
#include "pipeline/recording/time_unit.h"

namespace nightmap {
namespace {

// A sample and its line number.
struct LoggedSample {
  int line = 0;
  SignalSample sample;
};

using Words = std::vector<std::string_view>;

Words SplitAt(std::string_view line, char separator) {
  Words fields;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(separator, begin), line.size());
    fields.push_back(line.substr(begin, end - begin));
    begin = end + 1;
  }
  return fields;
}

// Reads one file: parses its lines, then sorts and accumulates.
class SignalFile {
 public:
  SignalFile(const SignalConfig& config,
             const SensorConfig& sensor,
             std::filesystem::path path,
             std::string name)
      : config_(config), sensor_(sensor), path_(std::move(path)), name_(std::move(name)) {}

  void Read() {
    VisitLogLines(path_, [&](int number, std::string_view line) {
      try {
        ReadLine(number, line);
      } catch (const DataError& error) {
        Skip(number, error.what());
      }
    });
    if (config_.sort) {
      std::ranges::stable_sort(
          samples_, {}, [](const LoggedSample& logged) { return logged.sample.time_ns; });
    }
  }

  // Appends the samples that are later than the existing ones, or keep their place.
  void AppendTo(std::vector<SignalSample>* samples) {
    std::optional<std::int64_t> stated_ns;  // by the line before, of this file
    for (LoggedSample& logged : samples_) {
      const std::int64_t time_ns = logged.sample.time_ns;
      if (!samples->empty() && samples->back().time_ns >= time_ns) {
        const std::int64_t last_ns = samples->back().time_ns;
        if (!KeepsPlace(time_ns, last_ns, stated_ns)) {
          Skip(logged.line,
               fmt::format("time {} s is not after {} s of the sample before",
                           TimeToString(time_ns),
                           TimeToString(last_ns)));
          continue;
        }
        logged.sample.time_ns = last_ns + kLineStep_ns;
      }
      if (!HasSameBeams(logged, *samples)) continue;
      num_in_line_order_ += logged.sample.time_ns == time_ns ? 0 : 1;
      stated_ns = time_ns;
      samples->push_back(std::move(logged.sample));
    }
  }

  void Check(double max_failed_ratio) const {
    CheckUnit();
    const std::string file = path_.string();
    if (samples_.empty()) {
      throw DataError("{}: holds no sample of {}{}: correct `file`, `format` or `message` in {}",
                      file,
                      NameOf(sensor_.kind),
                      problems_.empty() ? "" : " (" + problems_.front() + ")",
                      config_.source);
    }
    const double num_lines = static_cast<double>(num_lines_);
    if (static_cast<double>(problems_.size()) <= max_failed_ratio * num_lines) return;
    throw DataError(
        "{}: {} of {} lines are no sample in order (the first: {}), more than max_failed_ratio = "
        "{}: repair the file or correct {}{}{}",
        file,
        problems_.size(),
        num_lines_,
        problems_.front(),
        max_failed_ratio,
        config_.source,
        config_.sort ? "" : ", or set sort = true where lines are out of order",
        config_.format == "carmen" && config_.rate_hz == 0 ? ", or rate_hz where they have no times"
                                                           : "");
  }

  const std::vector<std::string>& Problems() const { return problems_; }
  std::size_t NumInLineOrder() const { return num_in_line_order_; }

 private:
  void Skip(int line, const std::string& why) {
    problems_.push_back(fmt::format("{}:{}: {}", name_, line, why));
  }

  // Whether a sample whose time is not after the last one is of that place in the log all the same.
  // A line that states the time of the line before says the same again; time 0 is none.
  bool KeepsPlace(std::int64_t time_ns,
                  std::int64_t last_ns,
                  const std::optional<std::int64_t>& stated_ns) const {
    return sensor_.kind != SignalKind::kAcceleration && !config_.sort && stated_ns &&
           *stated_ns != time_ns && time_ns != Offset_ns() && last_ns - time_ns < kMaxStepBack_ns;
  }

  // Leaves out a scan of another number of beams than the sensor's first.
  bool HasSameBeams(const LoggedSample& logged, const std::vector<SignalSample>& samples) {
    const std::size_t num_beams = logged.sample.ranges_m.size();
    if (samples.empty() || samples.front().ranges_m.size() == num_beams) return true;
    Skip(logged.line,
         fmt::format("{} beams, the sensor's first scan has {}: give each of two scanners a "
                     "[[sensor]] of its own",
                     num_beams,
                     samples.front().ranges_m.size()));
    return false;
  }

  std::int64_t Time_ns(std::int64_t time_ns) const {
    return CheckedTime_ns(CheckedTime_ns(time_ns) + Offset_ns());
  }

  std::int64_t Offset_ns() const { return std::llround(config_.time_offset_s * 1e9); }

  void ReadLine(int number, std::string_view line) {
    if (config_.format == "csv") return ReadCsvLine(number, line);
    const Words words = SplitWords(line);
    if (words.empty() || words[0].starts_with('#')) return;
    if (config_.format == "carmen" && words[0] != config_.message) return;
    ++num_lines_;
    SignalSample sample;
    if (config_.format == "carmen") {
      sample = CarmenSample(words);
    } else {
      sample = ParseValues(sensor_, LineTime_ns(words[0]), {words.begin() + 1, words.end()});
    }
    Add(number, std::move(sample));
  }

  // With a rate_hz the lines follow each other at it, whatever times they state.
  SignalSample CarmenSample(const Words& words) const {
    if (config_.rate_hz == 0) return ParseCarmenLine(sensor_, LineTime::kNeeded, words);
    SignalSample sample = ParseCarmenLine(sensor_, LineTime::kIgnored, words);
    sample.time_ns = std::llround(1e9 * static_cast<double>(num_lines_ - 1) / config_.rate_hz);
    return sample;
  }

  void ReadCsvLine(int number, std::string_view line) {
    if (number == 1) return FindColumns(line);
    if (line.empty()) return;
    ++num_lines_;
    const Words fields = SplitAt(line, ',');
    if (fields.size() != num_columns_) {
      throw DataError("{} fields, expected {}", fields.size(), num_columns_);
    }
    Words values;
    for (std::size_t i = 1; i < columns_.size(); ++i) values.push_back(fields[columns_[i]]);
    Add(number, ParseValues(sensor_, LineTime_ns(fields[columns_[0]]), values));
  }

  void FindColumns(std::string_view line) {
    const Words header = SplitAt(line, ',');
    num_columns_ = header.size();
    for (const std::string_view name : SplitAt(config_.columns, ',')) {
      const auto found = std::ranges::find(header, name);
      if (found == header.end()) {
        throw UsageError("{}: {} has no column '{}', it has: {}",
                         config_.source,
                         path_.string(),
                         name,
                         line.substr(0, 200));
      }
      columns_.push_back(static_cast<std::size_t>(found - header.begin()));
      if (columns_.size() == 1 && name.ends_with("_ns")) unit_ = TimeUnit::kNs;
    }
  }

  std::int64_t LineTime_ns(std::string_view text) {
    const auto time = times_.size() < kMaxTimesToJudge ? ParseReal(text) : std::nullopt;
    if (time) times_.push_back(*time);
    return ParseTime_ns(text, unit_);
  }

  void CheckUnit() const {
    if (!config_.time_unit.empty() || unit_ != TimeUnit::kS) return;
    const bool is_acceleration = sensor_.kind == SignalKind::kAcceleration;
    DemandSeconds(UnitLike(times_, is_acceleration ? kMaxAccelerationStep_s : kMaxFrameStep_s),
                  path_,
                  config_.source);
  }

  void Add(int number, SignalSample sample) {
    sample.time_ns = Time_ns(sample.time_ns);
    samples_.push_back({number, std::move(sample)});
  }

  const SignalConfig& config_;
  const SensorConfig& sensor_;
  std::filesystem::path path_;
  std::string name_;  // relative to the data folder, for the report
  std::size_t num_lines_ = 0;
  std::size_t num_in_line_order_ = 0;
  std::vector<std::size_t> columns_;
  std::size_t num_columns_ = 0;
  TimeUnit unit_ = UnitOf(config_.time_unit);
  std::vector<double> times_;  // as written
  std::vector<LoggedSample> samples_;
  std::vector<std::string> problems_;
};

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
    result.num_in_line_order[idx] += log.NumInLineOrder();
    result.problems.insert(result.problems.end(), log.Problems().begin(), log.Problems().end());
  }
  for (std::size_t i = 0; i < site.sensors.size(); ++i) {
    if (site.sensors[i].kind != SignalKind::kOdometry) continue;
    SumUpOdometry(site.sensors[i], &result.signals[i].samples);
  }
  return result;
}

}  // namespace nightmap
