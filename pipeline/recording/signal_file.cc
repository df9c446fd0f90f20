// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/signal_file.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/median.h"
#include "pipeline/io/csv.h"
#include "pipeline/io/text_file.h"
#include "pipeline/recording/gzip_lines.h"
#include "pipeline/recording/read_sequence.h"
#include "pipeline/recording/read_signals.h"

namespace nightmap {
namespace {

constexpr double kMaxChangeOfBeams = 0.25;  // of their number, from scan to scan of one scanner

}  // namespace

void SignalFile::Read() {
  VisitLogLines(path_, [&](int number, std::string_view line) {
    try {
      ReadLine(number, line);
    } catch (const DataError& error) {
      Skip(number, error.what());
    }
  });
  if (sensor_.kind == SignalKind::kScan) LeaveOutOtherScans();
  if (config_.sort) {
    std::ranges::stable_sort(
        samples_, {}, [](const LoggedSample& logged) { return logged.sample.time_ns; });
  }
}

std::string SignalFile::ClockName() const {
  if (!RowOf(sensor_.kind).has_line_clock || config_.sort || config_.rate_hz != 0) return "";
  const std::string column = config_.columns.substr(0, config_.columns.find(','));
  return fmt::format("{}\n{}\n{}\n{}", name_, config_.format, column, config_.time_unit);
}

void SignalFile::AppendStamps(int kind, std::vector<StampedLine>* lines) const {
  for (const StampedLine& stamp : stamps_) lines->push_back({stamp.line, kind, stamp.stated_ns});
}

void SignalFile::TakeTimes(const LineClock& clock) {
  std::int64_t last_ns = 0;
  std::erase_if(samples_, [&](LoggedSample& logged) {
    const std::int64_t stated_ns = logged.sample.time_ns - Offset_ns();
    const std::optional<std::int64_t> time_ns = clock.TimeOf_ns(logged.line);
    if (!time_ns) {
      Skip(logged.line,
           fmt::format("time {} s is not after {} s of the sample before",
                       TimeToString(stated_ns),
                       TimeToString(last_ns)));
      return true;
    }
    if (*time_ns != stated_ns) ++num_in_line_order_;
    last_ns = *time_ns;
    logged.sample.time_ns = *time_ns + Offset_ns();
    return false;
  });
}

void SignalFile::AppendTo(std::vector<SignalSample>* samples) {
  for (LoggedSample& logged : samples_) {
    if (!samples->empty() && samples->back().time_ns >= logged.sample.time_ns) {
      Skip(logged.line,
           fmt::format("time {} s is not after {} s of the sample before",
                       TimeToString(logged.sample.time_ns),
                       TimeToString(samples->back().time_ns)));
      continue;
    }
    samples->push_back(std::move(logged.sample));
  }
}

void SignalFile::Check(double max_failed_ratio) const {
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

void SignalFile::Skip(int line, const std::string& why) {
  problems_.push_back(fmt::format("{}:{}: {}", name_, line, why));
}

// A scanner that turns unevenly has a few beams more or less in each scan. Another number is of
// another scanner, or of a line that is cut off.
void SignalFile::LeaveOutOtherScans() {
  std::vector<std::size_t> counts;
  for (const LoggedSample& logged : samples_) counts.push_back(logged.sample.ranges_m.size());
  const auto usual = static_cast<double>(Median(counts));
  std::erase_if(samples_, [&](const LoggedSample& logged) {
    const auto num_beams = static_cast<double>(logged.sample.ranges_m.size());
    if (std::abs(num_beams - usual) <= kMaxChangeOfBeams * usual) return false;
    Skip(logged.line,
         fmt::format("{} beams, most scans have about {}: give each of two scanners a [[sensor]] "
                     "of its own",
                     num_beams,
                     usual));
    return true;
  });
}

std::int64_t SignalFile::Offset_ns() const { return std::llround(config_.time_offset_s * 1e9); }

void SignalFile::ReadLine(int number, std::string_view line) {
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
SignalSample SignalFile::CarmenSample(const Words& words) const {
  if (config_.rate_hz == 0) return ParseCarmenLine(sensor_, LineTime::kNeeded, words);
  SignalSample sample = ParseCarmenLine(sensor_, LineTime::kIgnored, words);
  sample.time_ns = std::llround(1e9 * static_cast<double>(num_lines_ - 1) / config_.rate_hz);
  return sample;
}

void SignalFile::ReadCsvLine(int number, std::string_view line) {
  if (number == 1) {
    csv_.emplace(line, config_.columns, sensor_.kind, config_.source, path_.string());
    return;
  }
  if (line.empty()) return;
  ++num_lines_;
  const Words fields = csv_->FieldsOf(line);
  Add(number, ParseValues(sensor_, LineTime_ns(fields[0]), {fields.begin() + 1, fields.end()}));
}

std::int64_t SignalFile::LineTime_ns(std::string_view text) {
  const auto time = times_.size() < kMaxTimesToJudge ? ParseReal(text) : std::nullopt;
  if (time) times_.push_back(*time);
  return ParseTime_ns(text, unit_);
}

void SignalFile::CheckUnit() const {
  if (!config_.time_unit.empty() || unit_ != TimeUnit::kS) return;
  DemandSeconds(UnitLike(times_, RowOf(sensor_.kind).max_step_s), path_, config_.source);
}

void SignalFile::Add(int number, SignalSample sample) {
  const std::int64_t stated_ns = CheckedTime_ns(sample.time_ns);
  sample.time_ns = CheckedTime_ns(stated_ns + Offset_ns());
  stamps_.push_back({number, 0, stated_ns});
  samples_.push_back({number, std::move(sample)});
}

}  // namespace nightmap
