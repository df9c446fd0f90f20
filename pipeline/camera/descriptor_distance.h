// SPDX-License-Identifier: Apache-2.0
// Distance between two descriptors, in integers so that it is exact and the same on every machine.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "pipeline/io/features_io.h"

namespace nightmap {

// Squared L2 distance of byte vectors. A plain loop, because compilers vectorize it best.
inline int SquaredDistance(const std::uint8_t* a, const std::uint8_t* b, int size) {
  int sum = 0;
  for (int i = 0; i < size; ++i) {
    const int difference = static_cast<int>(a[i]) - static_cast<int>(b[i]);
    sum += difference * difference;
  }
  return sum;
}

// Number of differing bits; `size` is a multiple of 8.
inline int HammingDistance(const std::uint8_t* a, const std::uint8_t* b, int size) {
  int sum = 0;
  for (int i = 0; i < size; i += 8) {
    std::uint64_t word_a = 0;
    std::uint64_t word_b = 0;
    std::memcpy(&word_a, a + i, 8);
    std::memcpy(&word_b, b + i, 8);
    sum += std::popcount(word_a ^ word_b);
  }
  return sum;
}

// Squared L2 for RootSIFT, differing bits for ORB and BRISK; comparable only within one kind.
inline int DescriptorDistance(DescriptorKind kind, const std::uint8_t* a, const std::uint8_t* b) {
  switch (kind) {
    case DescriptorKind::kRootSift:
      return SquaredDistance(a, b, 128);
    case DescriptorKind::kOrb:
      return HammingDistance(a, b, 32);
    case DescriptorKind::kBrisk:
      return HammingDistance(a, b, 64);
  }
  return 0;
}

// The distance of two descriptors that are `relative` times as far apart as unrelated ones: L2 of
// unit vectors for RootSIFT (about 1 when unrelated), half of the bits for ORB and BRISK.
int DistanceFromRelative(DescriptorKind kind, double relative);

// Lowe's ratio test on two distances of DescriptorDistance; the ratio is that of L2 or of Hamming
// distances.
bool PassesRatioTest(DescriptorKind kind, int best, int second, double max_ratio);

}  // namespace nightmap
