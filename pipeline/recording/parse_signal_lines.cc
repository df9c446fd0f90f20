// SPDX-License-Identifier: Apache-2.0
// Parses one line of a log into one sample, for read_signals.h.
#include <algorithm>
#include <charconv>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/io/csv.h"
#include "pipeline/io/text_file.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/recording/read_signals.h"
#include "pipeline/recording/scan_angles.h"

namespace nightmap {
namespace {

constexpr double kMaxPosition = 1e7;  // of odometry from its start, in its unit
constexpr double kMaxHeading = 1e6;   // likewise; large, because odometry may count turns
constexpr double kMaxErrorOfQuaternion = 0.05;
constexpr double kMaxTicks = 1e12;
constexpr double kMaxRange_m = 1e4;
constexpr double kMaxReading = 1e6;  // of a range, in its unit
constexpr std::size_t kMaxBeams = 100'000;

using Words = std::vector<std::string_view>;

double Within(std::string_view word, double limit, std::string_view what) {
  const double value = RealWord(word);
  if (std::abs(value) <= limit) return value;
  throw DataError("{} is {}, beyond {}", what, word, limit);
}

void DemandCount(const Words& words, std::size_t count, std::string_view what) {
  if (words.size() == count) return;
  throw DataError("{} words, expected {} ({})", words.size(), count, what);
}

double HeadingWord_rad(const SensorConfig& sensor, std::string_view word, const char* what) {
  return sensor.heading_unit_rad.value_or(1) * Within(word, kMaxHeading, what);
}

Eigen::Vector3d ParsePose(const SensorConfig& sensor,
                          std::string_view x,
                          std::string_view y,
                          std::string_view heading) {
  return {sensor.position_unit_m * Within(x, kMaxPosition, "x"),
          sensor.position_unit_m * Within(y, kMaxPosition, "y"),
          HeadingWord_rad(sensor, heading, "heading")};
}

// x y qx qy qz qw, or x y z qx qy qz qw as in TUM's format.
Eigen::Vector3d ParsePoseWithRotation(const SensorConfig& sensor, const Words& values) {
  const std::size_t first = values.size() - 4;
  Eigen::Vector4d q;
  for (Eigen::Index i = 0; i < 4; ++i) q[i] = RealWord(values[first + static_cast<std::size_t>(i)]);
  if (!(std::abs(q.norm() - 1) < kMaxErrorOfQuaternion)) {
    throw DataError("the quaternion qx qy qz qw has length {:.3g}, not 1", q.norm());
  }
  const Eigen::Vector3d ahead = Eigen::Quaterniond(q.normalized()) * Eigen::Vector3d::UnitX();
  return {sensor.position_unit_m * Within(values[0], kMaxPosition, "x"),
          sensor.position_unit_m * Within(values[1], kMaxPosition, "y"),
          std::atan2(ahead.y(), ahead.x())};
}

Eigen::Vector3d ParseOdometry(const SensorConfig& sensor, const Words& values) {
  if (sensor.measures == "pose") {
    if (values.size() == 6 || values.size() == 7) return ParsePoseWithRotation(sensor, values);
    DemandCount(values, 3, "x y heading, x y qx qy qz qw, or x y z qx qy qz qw");
    return ParsePose(sensor, values[0], values[1], values[2]);
  }
  if (sensor.measures == "motion") {
    DemandCount(values, 2, "distance heading_change");
    return {sensor.position_unit_m * Within(values[0], kMaxPosition, "distance"),
            HeadingWord_rad(sensor, values[1], "heading_change"),
            0};
  }
  DemandCount(values, 2, "left right");
  return {Within(values[0], kMaxTicks, "left"), Within(values[1], kMaxTicks, "right"), 0};
}

// The three values as they are.
Eigen::Vector3d ParsePlainValues(const SignalKindRow& row, const Words& words) {
  const auto& values = row.values;
  if (words.size() != values.size()) {
    DemandCount(words, 3, values[0].name + " " + values[1].name + " " + values[2].name);
  }
  const auto value = [&](std::size_t i) { return Within(words[i], row.max_value, row.a_value); };
  return {value(0), value(1), value(2)};
}

// Where nothing was hit, drivers write NaN, a number below 0, or infinity or a large number beyond
// their reach: a range that is never a hit, and one that is never below a limit. So does an empty
// field of a table.
double ParseRange_m(const SensorConfig& sensor, std::string_view word) {
  if (word.empty()) return 0;
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc() && end == word.data() + word.size() && !std::isfinite(value)) {
    return value > 0 && std::isinf(value) ? kMaxRange_m : 0;
  }
  return std::clamp(sensor.range_unit_m * Within(word, kMaxReading, "a range"), 0.0, kMaxRange_m);
}

std::vector<float> ParseRanges(const SensorConfig& sensor,
                               const Words& words,
                               std::size_t first,
                               std::size_t count) {
  std::vector<float> ranges_m;
  for (std::size_t i = 0; i < count; ++i) {
    ranges_m.push_back(static_cast<float>(ParseRange_m(sensor, words[first + i])));
  }
  return ranges_m;
}

// The limit that holds for a scan whose line may state one. It is rounded as ranges are, so that a
// range as written is not below it.
double Limit_m(const SensorConfig& sensor, double of_line_m = 0) {
  const double unless_stated_m = of_line_m > 0 ? of_line_m : kMaxRangeUnlessStated_m;
  return static_cast<float>(sensor.max_range_m.value_or(unless_stated_m));
}

// A scan whose line states no angles and no limit.
SignalSample ScanOf(const SensorConfig& sensor, std::vector<float> ranges_m) {
  const Eigen::Vector2d angles_rad = BeamAngles_rad(sensor, ranges_m.size());
  return {0, {angles_rad[0], angles_rad[1], Limit_m(sensor)}, std::move(ranges_m)};
}

// Reads the word that counts the words after it; throws when the line has fewer than these and
// `after` more.
std::size_t CountAt(const Words& words, std::size_t at, std::size_t after) {
  if (at >= words.size()) throw DataError("{} words: the line is cut off", words.size());
  const auto count = ParseInteger(words[at]);
  if (!count || *count < 0 || *count > static_cast<std::int64_t>(kMaxBeams)) {
    throw DataError("'{}' is no count of beams", words[at]);
  }
  const std::size_t needed = at + 1 + static_cast<std::size_t>(*count) + after;
  if (words.size() < needed) {
    throw DataError("{} words for {} beams, expected {}", words.size(), *count, needed);
  }
  return static_cast<std::size_t>(*count);
}

constexpr std::size_t kStampWords = 3;  // time host logger_time, the end of a line

// Reads the time that follows `rest` words. It may be missing where it is ignored.
std::int64_t TimeAfter(const Words& words, std::size_t rest, LineTime line_time) {
  const bool lacks_time = line_time == LineTime::kIgnored && words.size() == rest;
  if (!lacks_time && words.size() != rest + kStampWords) {
    throw DataError("{} words, expected {}", words.size(), rest + kStampWords);
  }
  return line_time == LineTime::kIgnored ? 0 : ParseTime_ns(words[rest]);
}

std::size_t StampWords(LineTime line_time) {
  return line_time == LineTime::kIgnored ? 0 : kStampWords;
}

// FLASER n ranges x y theta odom_x odom_y odom_theta time host logger_time
SignalSample ParseOldLaser(const SensorConfig& sensor, LineTime line_time, const Words& words) {
  constexpr std::size_t kPoseWords = 6;
  const std::size_t count = CountAt(words, 1, kPoseWords + StampWords(line_time));
  const std::size_t pose = 2 + count;
  SignalSample sample;
  const std::int64_t time_ns = TimeAfter(words, pose + kPoseWords, line_time);
  if (sensor.kind == SignalKind::kScan) {
    if (count == 0) throw DataError("no beams");
    sample = ScanOf(sensor, ParseRanges(sensor, words, 2, count));
  } else {
    sample.value = ParsePose(sensor, words[pose + 3], words[pose + 4], words[pose + 5]);
  }
  sample.time_ns = time_ns;
  return sample;
}

// MESSAGE type start_angle field_of_view angle_step max_range accuracy remission_mode n ranges
// m remissions [laser x y theta, robot x y theta, tv rv forward_safety side_safety turn_axis] time
// host logger_time
SignalSample ParseLaser(const SensorConfig& sensor, LineTime line_time, const Words& words) {
  const std::size_t pose_words = words[0] == "ROBOTLASER1" ? 11 : 0;
  const std::size_t after = pose_words + StampWords(line_time);
  const std::size_t count = CountAt(words, 8, 1 + after);
  const std::size_t num_remissions = CountAt(words, 9 + count, after);
  const std::size_t rest = 10 + count + num_remissions;
  SignalSample sample;
  const std::int64_t time_ns = TimeAfter(words, rest + pose_words, line_time);
  if (sensor.kind == SignalKind::kScan) {
    if (count == 0) throw DataError("no beams");
    sample.ranges_m = ParseRanges(sensor, words, 9, count);
    const LineAngles angles{Within(words[2], 7, "start_angle"),
                            Within(words[3], 7, "field_of_view"),
                            Within(words[4], 2, "angle_step")};
    const double of_line_m = sensor.range_unit_m * Within(words[5], kMaxReading, "max_range");
    sample.value << BeamAngles_rad(sensor, count, angles), Limit_m(sensor, of_line_m);
  } else {
    sample.value = ParsePose(sensor, words[rest + 3], words[rest + 4], words[rest + 5]);
  }
  sample.time_ns = time_ns;
  return sample;
}

}  // namespace

SignalSample ParseCarmenLine(const SensorConfig& sensor, LineTime line_time, const Words& words) {
  if (words[0] == "ODOM") {  // x y theta tv rv acceleration time host logger_time
    constexpr std::size_t kRest = 7;
    const std::int64_t time_ns = TimeAfter(words, kRest, line_time);
    return {time_ns, ParsePose(sensor, words[1], words[2], words[3]), {}};
  }
  if (words[0] == "ROBOTLASER1" || words[0] == "RAWLASER1") {
    return ParseLaser(sensor, line_time, words);
  }
  return ParseOldLaser(sensor, line_time, words);
}

SignalSample ParseValues(const SensorConfig& sensor, std::int64_t time_ns, const Words& values) {
  SignalSample sample;
  if (sensor.kind == SignalKind::kScan) {
    if (values.empty() || values.size() > kMaxBeams) {
      throw DataError("{} ranges, expected 1 to {}", values.size(), kMaxBeams);
    }
    sample = ScanOf(sensor, ParseRanges(sensor, values, 0, values.size()));
  } else if (sensor.kind == SignalKind::kOdometry) {
    sample.value = ParseOdometry(sensor, values);
  } else {
    sample.value = ParsePlainValues(RowOf(sensor.kind), values);
  }
  sample.time_ns = time_ns;
  return sample;
}

}  // namespace nightmap
