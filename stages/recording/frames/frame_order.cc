// SPDX-License-Identifier: Apache-2.0
#include "stages/recording/frames/frame_order.h"

#include <algorithm>
#include <tuple>

#include "pipeline/base/error.h"
#include "pipeline/io/trajectory_io.h"

namespace nightmap {
namespace {

// Whether sequence s continues the group of the one before it, which recorded at once.
bool JoinsPrevious(const std::vector<RawSequence>& sequences, std::size_t s) {
  return s > 0 && !sequences[s].rig.empty() && sequences[s].rig == sequences[s - 1].rig;
}

void CheckFollows(const RawSequence& previous, const RawSequence& sequence) {
  if (sequence.frames.front().time_ns > previous.frames.back().time_ns) return;
  throw DataError(
      "{}: starts at {} s, before the recording of {} ends at {} s: set time_offset_s so that "
      "recordings follow each other; those of cameras that record at once need the same `rig`",
      sequence.name,
      TimeToString(sequence.frames.front().time_ns),
      previous.name,
      TimeToString(previous.frames.back().time_ns));
}

int CameraOf(const RawSequence& sequence) { return sequence.frames.front().camera_idx; }

}  // namespace

std::vector<OrderedFrame> OrderFrames(const std::vector<RawSequence>& sequences) {
  const auto key = [&](const OrderedFrame& one) {
    const RawFrame& frame = sequences[one.sequence_idx].frames[one.frame];
    return std::tuple(frame.time_ns, frame.camera_idx, one.sequence_idx, one.frame);
  };
  std::vector<OrderedFrame> order;
  std::size_t group_start = 0;
  for (std::size_t s = 0; s < sequences.size(); ++s) {
    if (!JoinsPrevious(sequences, s)) group_start = order.size();
    for (std::size_t i = 0; i < sequences[s].frames.size(); ++i) {
      order.push_back({s, i, sequences[s].frames[i].time_ns});
    }
    if (JoinsPrevious(sequences, s)) {
      std::ranges::sort(
          order.begin() + static_cast<std::ptrdiff_t>(group_start), order.end(), {}, key);
    }
  }
  for (std::size_t i = 1; i < order.size(); ++i) {
    order[i].time_ns = std::max(order[i].time_ns, order[i - 1].time_ns + 1);
  }
  return order;
}

void CheckTimesIncrease(const std::vector<RawSequence>& sequences) {
  std::size_t group_start = 0;
  for (std::size_t s = 0; s < sequences.size(); ++s) {
    if (!JoinsPrevious(sequences, s)) group_start = s;
    if (sequences[s].frames.empty()) continue;
    for (std::size_t p = s; p-- > 0;) {
      if (sequences[p].frames.empty()) continue;
      if (p >= group_start && CameraOf(sequences[p]) != CameraOf(sequences[s])) continue;
      CheckFollows(sequences[p], sequences[s]);
    }
  }
}

}  // namespace nightmap
