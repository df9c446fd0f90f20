// SPDX-License-Identifier: Apache-2.0
// The order of a site's frames in its lists.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/recording/read_sequence.h"

namespace nightmap {

// A frame's place in its sequence, and its time in the lists.
struct OrderedFrame {
  std::size_t sequence_idx;
  std::size_t frame;
  std::int64_t time_ns;
};

// Sequence after sequence. Neighbouring sequences of one rig are merged by time; at equal times
// cameras keep the order of the site config. A time that is not after the one before it becomes 1
// ns later than that one, so that times are unique. Pure and deterministic.
std::vector<OrderedFrame> OrderFrames(const std::vector<RawSequence>& sequences);

// Throws DataError when two sequences overlap in time, unless they are of two cameras of one rig
// and have no sequence of another rig between them.
void CheckTimesIncrease(const std::vector<RawSequence>& sequences);

}  // namespace nightmap
