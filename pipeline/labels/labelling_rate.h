// SPDX-License-Identifier: Apache-2.0
// Which frames of a recording a network labels even if nothing new is made of them.
#pragma once

#include <vector>

#include "pipeline/io/frames_io.h"

namespace nightmap {

// By frame: every n-th one of each sequence, from its first in the list. n is the median frame rate
// of the sequence over `rate_hz`, rounded, and at least 1.
std::vector<bool> FramesAtRate(const std::vector<FrameRecord>& frames, double rate_hz);

}  // namespace nightmap
