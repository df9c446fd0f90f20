// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_mosaic/counted_median.h"

#include <algorithm>
#include <numeric>

namespace nightmap {
namespace {

constexpr double kStep = 0.01;

}  // namespace

void CountedMedian::Add(double value) {
  const auto step = static_cast<std::size_t>(value / kStep);
  if (counts_.size() <= step) counts_.resize(step + 1);
  ++counts_[step];
}

void CountedMedian::Add(const CountedMedian& others) {
  counts_.resize(std::max(counts_.size(), others.counts_.size()));
  for (std::size_t i = 0; i < others.counts_.size(); ++i) counts_[i] += others.counts_[i];
}

double CountedMedian::Get() const {
  const auto num = std::accumulate(counts_.begin(), counts_.end(), std::uint64_t{0});
  std::uint64_t until = 0;
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    until += counts_[i];
    if (2 * until > num) return (static_cast<double>(i) + 0.5) * kStep;
  }
  return 0;
}

}  // namespace nightmap
