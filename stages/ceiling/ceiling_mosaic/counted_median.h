// SPDX-License-Identifier: Apache-2.0
// The median of any number of values, without a list of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace nightmap {

// Values from 0 on are counted in steps of 0.01; memory is that of the largest value's steps.
class CountedMedian {
 public:
  void Add(double value);
  void Add(const CountedMedian& others);
  // The middle of the step that the median (of an even number the greater of both) is in; 0 without
  // values.
  double Get() const;

 private:
  std::vector<std::uint64_t> counts_;
};

}  // namespace nightmap
