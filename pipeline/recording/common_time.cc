// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/common_time.h"

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/recording/read_sequence.h"

namespace nightmap {
namespace {

constexpr double kMinCovered = 0.5;  // of the scans

std::string SpanOf(const Signal& signal) {
  return fmt::format("\"{}\" from {} s to {} s",
                     signal.sensor_id,
                     TimeToString(signal.samples.front().time_ns),
                     TimeToString(signal.samples.back().time_ns));
}

// Whether the times from the first to the last sample have a moment in common.
bool Meet(const Signal& a, const Signal& b) {
  return a.samples.front().time_ns <= b.samples.back().time_ns &&
         b.samples.front().time_ns <= a.samples.back().time_ns;
}

// The share of scans that odometry covers.
double Covered(const Signal& odometry, const Signal& scans) {
  const auto count = std::ranges::count_if(scans.samples, [&](const SignalSample& scan) {
    return scan.time_ns >= odometry.samples.front().time_ns &&
           scan.time_ns <= odometry.samples.back().time_ns;
  });
  return static_cast<double>(count) / static_cast<double>(scans.samples.size());
}

// Throws, because `odometry` meets no scans.
[[noreturn]] void RefuseOtherClock(const SiteConfig& site,
                                   std::size_t odometry_idx,
                                   const Signal& odometry,
                                   const Signal& scans) {
  const auto& config =
      *std::ranges::find(site.signals, static_cast<int>(odometry_idx), &SignalConfig::sensor_idx);
  const std::int64_t apart_ns = scans.samples.front().time_ns - odometry.samples.front().time_ns;
  throw DataError(
      "{}: odometry and scans have no moment in common: {}, {}: they have different clocks; where "
      "both started together, write time_offset_s = {:.6f} in the [[signal]] of \"{}\", else map "
      "without it",
      config.source,
      SpanOf(odometry),
      SpanOf(scans),
      config.time_offset_s + 1e-9 * static_cast<double>(apart_ns),
      odometry.sensor_id);
}

}  // namespace

std::vector<std::string> DemandCommonTime(const SiteConfig& site,
                                          const std::vector<Signal>& signals) {
  std::vector<std::string> hardly;
  if (!site.sequences.empty()) return hardly;
  for (std::size_t i = 0; i < signals.size(); ++i) {
    const Signal& odometry = signals[i];
    if (odometry.kind != SignalKind::kOdometry || odometry.samples.empty() ||
        odometry.sensor_id == site.robot_truth.odometry) {
      continue;
    }
    const Signal* of_other_clock = nullptr;
    bool meets = false;
    for (const Signal& scans : signals) {
      if (scans.kind != SignalKind::kScan || scans.samples.empty()) continue;
      if (!Meet(odometry, scans)) {
        of_other_clock = &scans;
        continue;
      }
      meets = true;
      const double covered = Covered(odometry, scans);
      if (covered >= kMinCovered) continue;
      hardly.push_back(fmt::format(
          "odometry covers only {:.0f} % of the scans: {}, {}; if their clocks differ, write "
          "time_offset_s in a [[signal]]",
          100 * covered,
          SpanOf(odometry),
          SpanOf(scans)));
    }
    if (!meets && of_other_clock) RefuseOtherClock(site, i, odometry, *of_other_clock);
  }
  return hardly;
}

}  // namespace nightmap
