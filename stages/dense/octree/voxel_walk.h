// SPDX-License-Identifier: Apache-2.0
// The voxels along a ray (Amanatides and Woo, A fast voxel traversal algorithm for ray tracing,
// 1987), with integers and without branches, because the processor cannot predict which axis comes
// next.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "pipeline/geometry/voxel_key.h"

namespace nightmap {

// The bits of a Morton code and, for each axis, all bits but the axis' own.
constexpr std::int64_t kMortonBits = 0xFFFFFFFFFFFF;
constexpr std::array<std::int64_t, 3> kOtherBits{
    ~0x249249249249, ~(0x249249249249 << 1), ~(0x249249249249 << 2)};

// State of a ray along one axis. T is one number or, for two rays at once, two.
template <typename T>
struct WalkAxis {
  T next_share{};  // share of the ray at which it leaves the voxel along this axis
  T share_per_voxel{};
  T step{};   // change of the voxel's code, one voxel ahead or back
  T voxel{};  // the axis' bits of the voxel's code; all others are set so that carries pass them
};

// Two numbers that the processor adds and compares as one (an extension of GCC and Clang).
using Lanes = std::int64_t __attribute__((vector_size(16)));

// All ones where a < b, else 0.
inline std::int64_t MaskLess(std::int64_t a, std::int64_t b) { return -std::int64_t{a < b}; }
inline Lanes MaskLess(Lanes a, Lanes b) { return a < b; }

template <typename T>
class WalkSteps {
 public:
  std::array<WalkAxis<T>, 3> axes;

  // Moves to the next voxel and returns its code.
  T Step() {
    auto& [x, y, z] = axes;
    const T y_before_x = MaskLess(y.next_share, x.next_share);
    const T not_x = y_before_x | MaskLess(z.next_share, x.next_share);
    const T is_y = y_before_x & ~MaskLess(z.next_share, y.next_share);
    Advance(~not_x, kOtherBits[0], x);
    Advance(is_y, kOtherBits[1], y);
    Advance(not_x & ~is_y, kOtherBits[2], z);
    return x.voxel & y.voxel & z.voxel & kMortonBits;
  }

 private:
  static void Advance(T mask, std::int64_t other_bits, WalkAxis<T>& axis) {
    axis.next_share += axis.share_per_voxel & mask;
    axis.voxel = (axis.voxel + (axis.step & mask)) | other_bits;
  }
};

class VoxelWalk {
 public:
  // Walks from `start` along `ray`, both in voxels.
  VoxelWalk(const Eigen::Vector3d& start, const Eigen::Vector3d& ray) {
    const VoxelKey first = start.array().floor().matrix().cast<int>();
    const auto code = static_cast<std::int64_t>(MortonCode(first));
    for (int axis = 0; axis < 3; ++axis) {
      const bool up = ray[axis] > 0;
      const double length = std::abs(ray[axis]);
      const double to_edge = up ? first[axis] + 1 - start[axis] : start[axis] - first[axis];
      const std::int64_t others = kOtherBits[static_cast<std::size_t>(axis)];
      WalkAxis<std::int64_t>& a = steps_.axes[static_cast<std::size_t>(axis)];
      a.share_per_voxel = Share(1 / length);
      a.next_share = length > 0 ? Share(to_edge / length) : a.share_per_voxel;
      a.step = up ? std::int64_t{1} << axis : ~others;
      a.voxel = code | others;
    }
  }

  // Calls visit(code) for each of the `count` voxels after the first.
  template <typename Visitor>
  void Visit(int count, const Visitor& visit) const {
    for (WalkSteps<std::int64_t> steps = steps_; count > 0; --count) {
      visit(static_cast<std::uint64_t>(steps.Step()));
    }
  }

 private:
  friend class VoxelWalkPair;

  // Units of 2^-40 of the ray; capped far beyond its end.
  static std::int64_t Share(double share) {
    return static_cast<std::int64_t>(std::min(share, 0x1p20) * 0x1p40);
  }

  WalkSteps<std::int64_t> steps_;
};

// Walks two rays at a time: a step must wait for the step before it, but not for the other ray.
class VoxelWalkPair {
 public:
  // Calls visit(lane, code), lane 0 or 1, for the `count` voxels of `walk` after its first. Some
  // calls happen now, the others while further walks are added or at Finish().
  template <typename Visitor>
  void Add(const VoxelWalk& walk, int count, const Visitor& visit) {
    if (count <= 0) return;
    const int lane = left_[0] == 0 ? 0 : 1;
    left_[static_cast<std::size_t>(lane)] = count;
    for (std::size_t i = 0; i < 3; ++i) {
      const WalkAxis<std::int64_t>& from = walk.steps_.axes[i];
      WalkAxis<Lanes>& to = steps_.axes[i];
      to.next_share[lane] = from.next_share;
      to.share_per_voxel[lane] = from.share_per_voxel;
      to.step[lane] = from.step;
      to.voxel[lane] = from.voxel;
    }
    const int both = std::min(left_[0], left_[1]);
    WalkSteps<Lanes> steps = steps_;
    for (int i = 0; i < both; ++i) {
      const Lanes codes = steps.Step();
      visit(0, static_cast<std::uint64_t>(codes[0]));
      visit(1, static_cast<std::uint64_t>(codes[1]));
    }
    steps_ = steps;
    left_ = {left_[0] - both, left_[1] - both};
  }

  template <typename Visitor>
  void Finish(const Visitor& visit) {
    const int lane = left_[0] > 0 ? 0 : 1;
    for (int& left = left_[static_cast<std::size_t>(lane)]; left > 0; --left) {
      visit(lane, static_cast<std::uint64_t>(steps_.Step()[lane]));
    }
  }

 private:
  WalkSteps<Lanes> steps_;
  std::array<int, 2> left_{};  // voxels left to visit; between calls at least one lane has none
};

}  // namespace nightmap
