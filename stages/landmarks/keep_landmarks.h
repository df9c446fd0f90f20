// SPDX-License-Identifier: Apache-2.0
// Which landmarks stay when there are more than the map may have.
#pragma once

#include <cstddef>
#include <vector>

#include "stages/landmarks/finish_track.h"

namespace nightmap {

// Indices of at most `count` landmarks, ascending. The observers choose in turns: in each turn
// everyone chooses the landmark that it sees and most observers see (ties: the older) of those it
// has not chosen yet. So each keeps as many of its best as any other, whenever and however often
// its place was seen; only the last turn may end before every observer had its choice. Takes n log
// n of the number of observations. All when they are not too many.
std::vector<std::size_t> ChooseLandmarks(const std::vector<Landmark>& landmarks,
                                         std::size_t num_observers,
                                         std::size_t count);

}  // namespace nightmap
