// SPDX-License-Identifier: Apache-2.0
// Integer addresses of the cubes of a regular grid whose edges lie on multiples of the cube's size.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

namespace nightmap {

// Cube [x, x+1) * size along each axis.
using VoxelKey = Eigen::Vector3i;

// The cubes with min <= key < max along each axis.
struct VoxelBox {
  VoxelKey min = VoxelKey::Zero();
  VoxelKey max = VoxelKey::Zero();

  bool Contains(const VoxelKey& key) const {
    return (key.array() >= min.array()).all() && (key.array() < max.array()).all();
  }
};

// Keys are packable while every coordinate is in [-kVoxelKeyReach, kVoxelKeyReach).
constexpr int kVoxelKeyReach = 1 << 20;

inline VoxelKey VoxelOf(const Eigen::Vector3d& point, double size_m) {
  return (point / size_m).array().floor().matrix().cast<int>();
}

inline Eigen::Vector3d VoxelCentre(const VoxelKey& key, double size_m) {
  return (key.cast<double>().array() + 0.5).matrix() * size_m;
}

// 21 bits per axis; packed keys sort by x, then y, then z.
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

// The lowest 16 bits of `value` with two zeros between successive bits.
inline std::uint64_t SpreadBits(std::uint64_t value) {
  value &= 0xFFFF;
  value = (value | value << 16) & 0x0000FF0000FF;
  value = (value | value << 8) & 0x00F00F00F00F;
  value = (value | value << 4) & 0x0C30C30C30C3;
  return (value | value << 2) & 0x249249249249;
}

// Morton code of a key with coordinates in [-2^15, 2^15): the leaf order of an octree of depth 16,
// with x in the lowest bit of each three.
inline std::uint64_t MortonCode(const VoxelKey& key) {
  const auto spread = [](int value) {
    return SpreadBits(static_cast<std::uint64_t>(value + (1 << 15)));
  };
  return spread(key.x()) | spread(key.y()) << 1 | spread(key.z()) << 2;
}

// Inverse of SpreadBits.
inline std::uint64_t GatherBits(std::uint64_t value) {
  value &= 0x249249249249;
  value = (value | value >> 2) & 0x0C30C30C30C3;
  value = (value | value >> 4) & 0x00F00F00F00F;
  value = (value | value >> 8) & 0x0000FF0000FF;
  return (value | value >> 16) & 0xFFFF;
}

inline VoxelKey KeyOfMortonCode(std::uint64_t code) {
  const auto axis = [code](int shift) {
    return static_cast<int>(GatherBits(code >> shift)) - (1 << 15);
  };
  return {axis(0), axis(1), axis(2)};
}

}  // namespace nightmap
