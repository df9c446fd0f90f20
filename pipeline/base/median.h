// SPDX-License-Identifier: Apache-2.0
// The median of a list.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace nightmap {

// Takes the upper one of the two in the middle of an even number of values; 0 of none.
template <typename T>
T Median(std::vector<T> values) {
  if (values.empty()) return T{};
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace nightmap
