// SPDX-License-Identifier: Apache-2.0
#include "pipeline/labels/labelling_rate.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace nightmap {
namespace {

std::size_t StepOf(std::span<const FrameRecord> sequence, double rate_hz) {
  std::vector<std::int64_t> gaps_ns;
  for (std::size_t i = 1; i < sequence.size(); ++i) {
    gaps_ns.push_back(sequence[i].time_ns - sequence[i - 1].time_ns);
  }
  if (gaps_ns.empty()) return 1;
  const auto median = gaps_ns.begin() + static_cast<std::ptrdiff_t>(gaps_ns.size() / 2);
  std::ranges::nth_element(gaps_ns, median);
  const double gap_s = 1e-9 * static_cast<double>(std::max<std::int64_t>(*median, 1));
  const double step = std::round(1 / (gap_s * rate_hz));
  return static_cast<std::size_t>(std::clamp(step, 1.0, static_cast<double>(sequence.size())));
}

}  // namespace

std::vector<bool> FramesAtRate(const std::vector<FrameRecord>& frames, double rate_hz) {
  std::vector<bool> chosen(frames.size());
  std::size_t begin = 0;
  while (begin < frames.size()) {
    std::size_t end = begin + 1;
    while (end < frames.size() && frames[end].sequence_idx == frames[begin].sequence_idx) ++end;
    const std::size_t step =
        StepOf({frames.begin() + static_cast<std::ptrdiff_t>(begin), end - begin}, rate_hz);
    for (std::size_t i = begin; i < end; i += step) chosen[i] = true;
    begin = end;
  }
  return chosen;
}

}  // namespace nightmap
