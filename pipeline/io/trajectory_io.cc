// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/trajectory_io.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/io/csv.h"
#include "pipeline/io/text_file.h"

namespace nightmap {
namespace {

constexpr std::int64_t kNsPerSecond = 1'000'000'000;
constexpr int kMaxDigits = 18;  // of any number that surely fits 64 bits
constexpr double kMaxNormError = 0.05;
constexpr double kMaxPosition_m = 1e9;

// digits * 10^exponent, exactly as written; a double would round a time in 2024 to 200 ns.
struct Decimal {
  bool negative = false;
  std::string digits;
  int exponent = 0;
};

const char* NameOf(TimeUnit unit) {
  return unit == TimeUnit::kS    ? "seconds"
         : unit == TimeUnit::kMs ? "ms"
         : unit == TimeUnit::kUs ? "us"
                                 : "ns";
}

Decimal ParseDecimal(std::string_view text, TimeUnit unit) {
  const DataError error("'{}' is not a time in {}", text, NameOf(unit));
  Decimal decimal;
  std::string_view rest = text;
  if (const auto e = rest.find_first_of("eE"); e != std::string_view::npos) {
    std::string_view power = rest.substr(e + 1);
    if (power.starts_with('+')) power.remove_prefix(1);
    const auto value = ParseInteger(power);
    if (!value || *value < -kMaxDigits || *value > kMaxDigits) throw error;
    decimal.exponent = static_cast<int>(*value);
    rest = rest.substr(0, e);
  }
  decimal.negative = rest.starts_with('-');
  if (decimal.negative) rest.remove_prefix(1);
  bool fraction = false;
  for (const char c : rest) {
    if (c == '.' && !fraction) {
      fraction = true;
    } else if (c >= '0' && c <= '9') {
      decimal.digits += c;
      if (fraction) --decimal.exponent;
    } else {
      throw error;
    }
  }
  if (decimal.digits.empty()) throw error;
  return decimal;
}

StampedPose ParsePose(const std::vector<std::string_view>& words, TimeUnit unit) {
  if (words.size() != 8) {
    throw DataError("{} columns, expected 8 (time_s tx ty tz qx qy qz qw)", words.size());
  }
  std::array<double, 7> values{};
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = RealWord(words[i + 1]);
  StampedPose stamped;
  stamped.time_ns = ParseTime_ns(words[0], unit);
  stamped.pose.translation = {values[0], values[1], values[2]};
  if (stamped.pose.translation.cwiseAbs().maxCoeff() > kMaxPosition_m) {
    throw DataError("the position (columns 2 to 4) is farther than {} m: it must be in metres",
                    kMaxPosition_m);
  }
  stamped.pose.rotation = Eigen::Quaterniond(values[6], values[3], values[4], values[5]);
  if (std::abs(stamped.pose.rotation.norm() - 1) > kMaxNormError) {
    throw DataError("the quaternion (columns 5 to 8) has length {:.3g}, not 1",
                    stamped.pose.rotation.norm());
  }
  stamped.pose.rotation.normalize();
  return stamped;
}

// Avoids "-0.000000000", which would make equal poses differ.
std::string FixedPoint(double value, int num_decimals) {
  std::string text = fmt::format("{:.{}f}", value, num_decimals);
  if (text.starts_with('-') && text.find_first_not_of("-0.") == text.npos) text.erase(0, 1);
  return text;
}

}  // namespace

std::string TimeToString(std::int64_t time_ns) {
  const bool negative = time_ns < 0;
  const std::uint64_t magnitude =
      negative ? 0 - static_cast<std::uint64_t>(time_ns) : static_cast<std::uint64_t>(time_ns);
  const std::uint64_t fraction = magnitude % kNsPerSecond;
  const std::string sign = negative ? "-" : "";
  // Benchmarks write microseconds; nanoseconds appear only where they are not zero.
  if (fraction % 1000 == 0) {
    return fmt::format("{}{}.{:06}", sign, magnitude / kNsPerSecond, fraction / 1000);
  }
  return fmt::format("{}{}.{:09}", sign, magnitude / kNsPerSecond, fraction);
}

std::int64_t ParseTime_ns(std::string_view text, TimeUnit unit) {
  const DataError out_of_range("time '{}' is out of range: it must be in {}", text, NameOf(unit));
  Decimal decimal = ParseDecimal(text, unit);
  decimal.exponent += static_cast<int>(unit);
  bool round_up = false;
  if (decimal.exponent < 0) {  // more digits than nanoseconds: round half away from zero
    const std::size_t num_cut = static_cast<std::size_t>(-decimal.exponent);
    decimal.digits.insert(0, num_cut, '0');
    const std::size_t num_kept = decimal.digits.size() - num_cut;
    round_up = decimal.digits[num_kept] >= '5';
    decimal.digits.resize(num_kept);
  } else {
    decimal.digits.append(static_cast<std::size_t>(decimal.exponent), '0');
  }
  decimal.digits.erase(0, decimal.digits.find_first_not_of('0'));
  if (decimal.digits.size() > static_cast<std::size_t>(kMaxDigits) + 1) {
    throw out_of_range;
  }
  const auto value = decimal.digits.empty() ? 0 : ParseInteger(decimal.digits);
  if (!value || *value == std::numeric_limits<std::int64_t>::max()) throw out_of_range;
  const std::int64_t rounded = *value + (round_up ? 1 : 0);
  return decimal.negative ? -rounded : rounded;
}

std::string TrajectoryToTum(const std::vector<StampedPose>& poses,
                            const std::string& comment,
                            int num_decimals) {
  std::string text = fmt::format("# {}\n# time_s tx_m ty_m tz_m qx qy qz qw\n", comment);
  for (const auto& [time_ns, pose] : poses) {
    text += TimeToString(time_ns);
    // q and -q are one rotation: write the one with qw >= 0.
    const double sign = pose.rotation.w() < 0 ? -1 : 1;
    const Eigen::Vector4d q = sign * pose.rotation.coeffs();
    for (const double value : {pose.translation.x(), pose.translation.y(), pose.translation.z()}) {
      text += ' ' + FixedPoint(value, num_decimals);
    }
    for (int i = 0; i < 4; ++i) text += ' ' + FixedPoint(q[i], num_decimals);
    text += '\n';
  }
  return text;
}

std::vector<StampedPose> ReadTum(const std::filesystem::path& path, TimeUnit unit) {
  std::vector<StampedPose> poses;
  VisitWordLines(path, [&](const std::vector<std::string_view>& words) {
    poses.push_back(ParsePose(words, unit));
    if (poses.size() > 1 && poses.back().time_ns <= poses[poses.size() - 2].time_ns) {
      throw DataError("times must increase: sort the file and remove repeated times");
    }
  });
  return poses;
}

std::vector<StampedPose> ReadPoses(const std::filesystem::path& path) {
  auto poses = ReadTum(path);
  if (poses.empty()) {
    throw DataError("{}: holds no pose; delete it and run make again", path.string());
  }
  return poses;
}

int FindPose(const std::vector<StampedPose>& poses, std::int64_t time_ns) {
  const auto found = std::lower_bound(
      poses.begin(), poses.end(), time_ns, [](const StampedPose& pose, std::int64_t time) {
        return pose.time_ns < time;
      });
  if (found == poses.end() || found->time_ns != time_ns) return -1;
  return static_cast<int>(found - poses.begin());
}

std::optional<Rigid3> PoseAt(const std::vector<StampedPose>& poses,
                             std::int64_t time_ns,
                             std::int64_t max_gap_ns) {
  const auto next = std::ranges::lower_bound(poses, time_ns, {}, &StampedPose::time_ns);
  if (next == poses.end()) return std::nullopt;
  if (next->time_ns == time_ns) return next->pose;
  if (next == poses.begin()) return std::nullopt;
  const StampedPose& a = *std::prev(next);
  const StampedPose& b = *next;
  if (b.time_ns - a.time_ns > max_gap_ns) return std::nullopt;
  const double ratio =
      static_cast<double>(time_ns - a.time_ns) / static_cast<double>(b.time_ns - a.time_ns);
  return Rigid3{a.pose.rotation.slerp(ratio, b.pose.rotation),
                a.pose.translation + ratio * (b.pose.translation - a.pose.translation)};
}

}  // namespace nightmap
