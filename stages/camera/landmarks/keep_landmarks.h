// SPDX-License-Identifier: Apache-2.0
// Chooses which landmarks stay when the map may not hold them all.
#pragma once

#include <cstddef>
#include <vector>

#include "stages/camera/landmarks/landmark_of_track.h"

namespace nightmap {

// Indices of at most `count` landmarks, ascending; all of them if they are not too many. The
// observers choose in turns. In each turn every observer chooses, of the landmarks that it sees and
// has not chosen yet, the one with the most observers (ties: the older landmark). So each observer
// keeps as many of its best landmarks as any other, whenever and however often its place was seen;
// only the last turn may end before every observer has chosen. O(n log n) in the number of
// observations.
std::vector<std::size_t> ChooseLandmarks(const std::vector<Landmark>& landmarks,
                                         std::size_t num_observers,
                                         std::size_t count);

}  // namespace nightmap
