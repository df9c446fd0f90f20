// SPDX-License-Identifier: Apache-2.0
// Exact Euclidean distance transform of a grid in linear time (Meijster, Roerdink and Hesselink, A
// general algorithm for computing distance transforms in linear time, 2000).
#pragma once

#include <cstdint>
#include <vector>

namespace nightmap {

// Squared distance in cells, centre to centre, from each cell to the nearest blocked one (row by
// row, blocked != 0). With `outside_blocked` the cells beyond the border are blocked too. Without
// any blocked cell every value is at least width^2. Deterministic at any number of threads. Throws
// DataError when width + height is above 46340 (32-bit squares).
std::vector<std::int32_t> SquaredDistances(const std::vector<std::uint8_t>& blocked,
                                           int width,
                                           int height,
                                           bool outside_blocked,
                                           int num_threads);

}  // namespace nightmap
