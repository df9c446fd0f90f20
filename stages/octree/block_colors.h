// SPDX-License-Identifier: Apache-2.0
// Sums of the colors that hit the voxels of a block. Stores only hit voxels, since a surface
// crosses few of a block.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "stages/octree/voxel_block.h"

namespace nightmap {

struct ColorSum {
  std::array<std::uint32_t, 3> rgb{};
  std::uint32_t count = 0;

  void Add(const ColorSum& other) {
    for (std::size_t channel = 0; channel < 3; ++channel) rgb[channel] += other.rgb[channel];
    count += other.count;
  }

  // Rounded. Never pure white, which OctoMap reads as no color.
  std::array<std::uint8_t, 3> Mean() const {
    std::array<std::uint8_t, 3> mean{};
    for (std::size_t channel = 0; channel < 3; ++channel) {
      mean[channel] = static_cast<std::uint8_t>((rgb[channel] + count / 2) / count);
    }
    if (std::ranges::count(mean, 255) == 3) mean[2] = 254;
    return mean;
  }
};

class BlockColors {
 public:
  // `sums` holds one sum for each voxel of `hit`, in order.
  void Add(const BlockBits& hit, const ColorSum* sums) {
    BlockBits all = colored_;
    all |= hit;
    if (all != colored_) Widen(all);
    hit.ForEach([&](std::size_t index) { sums_[colored_.Rank(index)].Add(*sums++); });
  }

  // The voxel must have been hit.
  std::array<std::uint8_t, 3> Mean(std::size_t index) const {
    return sums_[colored_.Rank(index)].Mean();
  }

 private:
  void Widen(const BlockBits& all) {
    std::vector<ColorSum> sums(all.Count());
    auto old = sums_.begin();
    colored_.ForEach([&](std::size_t index) { sums[all.Rank(index)] = *old++; });
    sums_ = std::move(sums);
    colored_ = all;
  }

  BlockBits colored_;
  std::vector<ColorSum> sums_;  // by colored voxel, in order
};

}  // namespace nightmap
