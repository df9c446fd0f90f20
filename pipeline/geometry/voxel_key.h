// SPDX-License-Identifier: Apache-2.0
// Integer addresses of the cubes of a regular grid whose edges lie on multiples of the cube's size.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

namespace nightmap {

// Cube [x, x+1) * size along each axis.
using VoxelKey = Eigen::Vector3i;

// Keys are packable while every coordinate is in [-kVoxelKeyReach, kVoxelKeyReach).
constexpr int kVoxelKeyReach = 1 << 20;

inline VoxelKey VoxelOf(const Eigen::Vector3d& point, double size_m) {
  return (point / size_m).array().floor().matrix().cast<int>();
}

inline Eigen::Vector3d VoxelCentre(const VoxelKey& key, double size_m) {
  return (key.cast<double>().array() + 0.5).matrix() * size_m;
}

// 21 bits an axis; packed keys sort by x, then y, then z.
inline std::uint64_t PackVoxel(const VoxelKey& key) {
  const auto biased = [](int value) { return static_cast<std::uint64_t>(value + kVoxelKeyReach); };
  return biased(key.x()) << 42 | biased(key.y()) << 21 | biased(key.z());
}

inline VoxelKey UnpackVoxel(std::uint64_t packed) {
  const auto axis = [packed](int shift) {
    return static_cast<int>(packed >> shift & (2 * kVoxelKeyReach - 1)) - kVoxelKeyReach;
  };
  return {axis(42), axis(21), axis(0)};
}

}  // namespace nightmap
