// SPDX-License-Identifier: Apache-2.0
// Exact Euclidean distance transform of a grid in linear time (Meijster, Roerdink and Hesselink, A
// general algorithm for computing distance transforms in linear time, 2000).
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/base/uninitialized_vector.h"

namespace nightmap {

// First of the two phases: distance in cells, between centres, from each cell to the nearest
// blocked one in its column (row by row; blocked if != 0); width + height where there is none. With
// `outside_blocked` the cells beyond the border are blocked too. Deterministic at any number of
// threads. Throws DataError when width + height is above 46340 (32-bit squares).
UninitializedVector<std::uint16_t> ColumnDistances(const std::vector<std::uint8_t>& blocked,
                                                   int width,
                                                   int height,
                                                   bool outside_blocked,
                                                   int num_threads);

// Both phases: squared distance in cells from each cell to the nearest blocked one. Without any
// blocked cell every value is at least width^2. Arguments, determinism and errors as above.
std::vector<std::int32_t> SquaredDistances(const std::vector<std::uint8_t>& blocked,
                                           int width,
                                           int height,
                                           bool outside_blocked,
                                           int num_threads);

}  // namespace nightmap
