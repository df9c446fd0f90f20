// SPDX-License-Identifier: Apache-2.0
// Sums of the colors that hit the voxels of a block, and how many keyframes did. Stores only hit
// voxels, since a surface crosses few of a block.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "stages/dense/octree/voxel_block.h"

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
  static constexpr int kMaxKeyframes = 255;  // counts end there

  // Adds the hits of one keyframe. `sums` holds one sum for each voxel of `hit`, in order.
  void Add(const BlockBits& hit, const ColorSum* sums) {
    BlockBits all = colored_;
    all |= hit;
    if (all != colored_) Widen(all);
    hit.ForEach([&](std::size_t index) {
      const std::size_t rank = colored_.Rank(index);
      sums_[rank].Add(*sums++);
      if (num_keyframes_[rank] < kMaxKeyframes) ++num_keyframes_[rank];
    });
  }

  // The voxel must have been hit.
  std::array<std::uint8_t, 3> Mean(std::size_t index) const {
    return sums_[colored_.Rank(index)].Mean();
  }

  int NumKeyframes(std::size_t index) const {
    return colored_.Test(index) ? num_keyframes_[colored_.Rank(index)] : 0;
  }

 private:
  void Widen(const BlockBits& all) {
    std::vector<ColorSum> sums(all.Count());
    std::vector<std::uint8_t> num_keyframes(sums.size());
    std::size_t old = 0;
    colored_.ForEach([&](std::size_t index) {
      const std::size_t rank = all.Rank(index);
      sums[rank] = sums_[old];
      num_keyframes[rank] = num_keyframes_[old++];
    });
    sums_ = std::move(sums);
    num_keyframes_ = std::move(num_keyframes);
    colored_ = all;
  }

  BlockBits colored_;
  std::vector<ColorSum> sums_;  // by colored voxel, in order
  std::vector<std::uint8_t> num_keyframes_;
};

}  // namespace nightmap
