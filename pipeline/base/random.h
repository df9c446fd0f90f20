// SPDX-License-Identifier: Apache-2.0
// Seeded random numbers whose sequence does not depend on the standard library.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace nightmap {

// SplitMix64 (Steele, Lea, Flood, OOPSLA 2014): small, fast, and good enough for RANSAC and noise.
class Random {
 public:
  // Independent streams: derive one per item, e.g. Random(seed, frame_idx), never share one.
  explicit Random(std::uint64_t seed, std::uint64_t stream = 0, std::uint64_t substream = 0)
      : state_(Mix(seed + kGolden) ^ Mix(stream + 2 * kGolden) ^ Mix(substream + 3 * kGolden)) {}

  std::uint64_t Next() { return Mix(state_ += kGolden); }
  // Uniform in [0, 1).
  double Uniform() { return static_cast<double>(Next() >> 11) * 0x1.0p-53; }
  double Uniform(double low, double high) { return low + (high - low) * Uniform(); }
  // Uniform in [0, size).
  std::size_t Index(std::size_t size) {
    return static_cast<std::size_t>((static_cast<unsigned __int128>(Next()) * size) >> 64);
  }
  // Normal with mean 0 and standard deviation 1 (Box-Muller).
  double Gaussian() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - Uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * Uniform());
  }

 private:
  static constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15ULL;
  static std::uint64_t Mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
};

}  // namespace nightmap
