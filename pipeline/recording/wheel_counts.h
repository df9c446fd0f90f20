// SPDX-License-Identifier: Apache-2.0
// Counters of wheels that begin again.
#pragma once

#include <vector>

namespace nightmap {

// The counts of one wheel without the jumps of a counter of 8, 16 or 32 bits, signed or not, that
// begins again at its other end. Counts that do not reach both ends of such a counter stay as they
// are. Pure.
std::vector<double> UnwrapCounts(std::vector<double> counts);

}  // namespace nightmap
