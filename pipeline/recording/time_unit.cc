// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/time_unit.h"

#include <algorithm>
#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/base/median.h"
#include "pipeline/io/csv.h"
#include "pipeline/io/text_file.h"
#include "pipeline/recording/read_sequence.h"

namespace nightmap {
namespace {

constexpr double kMaxTime_s = 1e-9 * static_cast<double>(kMaxTime_ns);
constexpr std::size_t kMinNumSteps = 10;
constexpr double kMaxLikelyStep_s = 2;  // of a sensor that records without pause

}  // namespace

TimeUnit UnitOf(const std::string& time_unit) {
  if (time_unit == "ms") return TimeUnit::kMs;
  if (time_unit == "us") return TimeUnit::kUs;
  if (time_unit == "ns") return TimeUnit::kNs;
  return TimeUnit::kS;
}

std::string UnitLike(const std::vector<double>& times, double max_step_s) {
  if (times.empty()) return "";
  const double time =
      std::abs(*std::ranges::min_element(times, {}, [](double t) { return std::abs(t); }));
  std::vector<double> steps;
  for (std::size_t i = 1; i < times.size(); ++i) steps.push_back(std::abs(times[i] - times[i - 1]));
  const double step = steps.size() < kMinNumSteps ? 0 : Median(steps);
  if (time <= kMaxTime_s && step <= max_step_s) return "";
  // The coarsest unit in which the times fit a clock, and follow each other as samples do.
  if (time * 1e-3 <= kMaxTime_s && step * 1e-3 <= kMaxLikelyStep_s) return "ms";
  if (time * 1e-6 <= kMaxTime_s && step * 1e-6 <= kMaxLikelyStep_s) return "us";
  return "ns";
}

std::string UnitLike(const std::filesystem::path& path, double max_step_s) {
  std::vector<double> times;
  VisitWordLines(path, [&](const std::vector<std::string_view>& words) {
    const auto time = times.size() < kMaxTimesToJudge ? ParseReal(words[0]) : std::nullopt;
    if (time) times.push_back(*time);
  });
  return UnitLike(times, max_step_s);
}

void DemandSeconds(const std::string& unit_like,
                   const std::filesystem::path& path,
                   const std::string& source) {
  if (unit_like.empty()) return;
  throw DataError(
      "{}: its times cannot be in seconds, they look like {}: write time_unit = \"{}\" in the "
      "table at {}, or time_unit = \"s\" if they are seconds",
      path.string(),
      unit_like,
      unit_like,
      source);
}

}  // namespace nightmap
