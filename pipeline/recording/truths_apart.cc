// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/truths_apart.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdlib>
#include <limits>

#include "pipeline/recording/frame_lists.h"

namespace nightmap {
namespace {

bool HasTruth(const RawSequence& sequence) {
  return std::ranges::any_of(sequence.frames, [&](const RawFrame& frame) {
    return TruthAt(sequence.ground_truth, frame.time_ns).has_value();
  });
}

std::int64_t TimeApart_ns(const RawSequence& sequence) {
  std::int64_t least_ns = std::numeric_limits<std::int64_t>::max();
  const auto& truth = sequence.ground_truth;
  for (const RawFrame& frame : sequence.frames) {
    const auto next = std::ranges::lower_bound(truth, frame.time_ns, {}, &StampedPose::time_ns);
    if (next != truth.end()) least_ns = std::min(least_ns, next->time_ns - frame.time_ns);
    if (next != truth.begin()) {
      least_ns = std::min(least_ns, frame.time_ns - std::prev(next)->time_ns);
    }
  }
  return least_ns;
}

}  // namespace

void ReportTruthsApart(const std::vector<RawSequence>& sequences, nlohmann::json& report) {
  for (const RawSequence& sequence : sequences) {
    if (sequence.ground_truth.empty() || HasTruth(sequence)) continue;
    const double apart_s = 1e-9 * static_cast<double>(TimeApart_ns(sequence));
    report["ground_truths_apart"].push_back(
        {{"file", sequence.ground_truth_file}, {"apart_s", apart_s}});
    spdlog::warn(
        "{}: {} gives no frame a pose: the nearest of its times is {:.6g} s from a frame's (poses "
        "on both sides of a frame may be 0.1 s apart); correct its times to the clock of the "
        "frames, or name another ground_truth (time_offset_s moves both)",
        sequence.name,
        sequence.ground_truth_file,
        apart_s);
  }
}

}  // namespace nightmap
