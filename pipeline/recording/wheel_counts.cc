// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/wheel_counts.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace nightmap {
namespace {

constexpr int kCounterBits[] = {8, 16, 32};
// A counter that begins again was near both of its ends, within this share of its range.
constexpr double kNearEnd = 0.1;

// How many different counts the counter has; none: it never begins again.
std::optional<double> PeriodOf(const std::vector<double>& counts) {
  const auto [least, most] = std::ranges::minmax_element(counts);
  for (const int bits : kCounterBits) {
    const double period = std::ldexp(1.0, bits);
    for (const double first : {0.0, -period / 2}) {
      const double near = kNearEnd * period;
      if (*least < first || *most >= first + period) continue;
      if (*least < first + near && *most >= first + period - near) return period;
    }
  }
  return std::nullopt;
}

}  // namespace

std::vector<double> UnwrapCounts(std::vector<double> counts) {
  if (counts.empty()) return counts;
  const auto period = PeriodOf(counts);
  if (!period) return counts;
  double added = 0;
  double last = counts.front();
  for (double& count : counts) {
    // The shorter way round from the count before.
    if (count - last > *period / 2) added -= *period;
    if (last - count > *period / 2) added += *period;
    last = count;
    count += added;
  }
  return counts;
}

}  // namespace nightmap
