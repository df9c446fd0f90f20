// SPDX-License-Identifier: Apache-2.0
// The voxels along a ray (Amanatides and Woo, A fast voxel traversal algorithm for ray tracing,
// 1987), in integers and without branches: which axis comes next cannot be predicted.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "pipeline/geometry/voxel_key.h"

namespace nightmap {

// The bits of one axis in a Morton code.
constexpr std::array<std::uint64_t, 3> kMortonAxis{
    0x249249249249, 0x249249249249 << 1, 0x249249249249 << 2};

class VoxelWalk {
 public:
  // From `start` along `ray`, both in voxels.
  VoxelWalk(const Eigen::Vector3d& start, const Eigen::Vector3d& ray) {
    const VoxelKey first = start.array().floor().matrix().cast<int>();
    voxel_ = MortonCode(first);
    for (int axis = 0; axis < 3; ++axis) {
      const bool up = ray[axis] > 0;
      const double length = std::abs(ray[axis]);
      const double to_edge = up ? first[axis] + 1 - start[axis] : start[axis] - first[axis];
      Axis& a = axes_[static_cast<std::size_t>(axis)];
      a.share_per_voxel = Share(1 / length);
      a.next_share = length > 0 ? Share(to_edge / length) : a.share_per_voxel;
      a.step = up ? std::uint64_t{1} << axis : kMortonAxis[static_cast<std::size_t>(axis)];
    }
  }

  // visit(code) for each of the `count` voxels after the first.
  template <typename Visitor>
  void Visit(int count, const Visitor& visit) const {
    std::uint64_t voxel = voxel_;
    auto [x, y, z] = axes_;
    for (; count > 0; --count) {
      const std::uint64_t is_x =
          AllOnesIf((x.next_share <= y.next_share) & (x.next_share <= z.next_share));
      const std::uint64_t is_y =
          AllOnesIf((y.next_share < x.next_share) & (y.next_share <= z.next_share));
      const std::uint64_t is_z = ~(is_x | is_y);
      x.next_share += x.share_per_voxel & is_x;
      y.next_share += y.share_per_voxel & is_y;
      z.next_share += z.share_per_voxel & is_z;
      const std::uint64_t axis =
          (kMortonAxis[0] & is_x) | (kMortonAxis[1] & is_y) | (kMortonAxis[2] & is_z);
      const std::uint64_t step = (x.step & is_x) | (y.step & is_y) | (z.step & is_z);
      // Adds within the bits of the axis: the ones between them let carries through.
      voxel = (((voxel | ~axis) + step) & axis) | (voxel & ~axis);
      visit(voxel);
    }
  }

 private:
  struct Axis {
    std::uint64_t next_share = 0;  // of the ray, at which the voxel is left along this axis
    std::uint64_t share_per_voxel = 0;
    std::uint64_t step = 0;  // one voxel ahead or back
  };

  // In units of 2^-40 of the ray; capped far beyond its end.
  static std::uint64_t Share(double share) {
    return static_cast<std::uint64_t>(std::min(share, 0x1p20) * 0x1p40);
  }
  static std::uint64_t AllOnesIf(bool condition) { return -static_cast<std::uint64_t>(condition); }

  std::uint64_t voxel_ = 0;
  std::array<Axis, 3> axes_;
};

}  // namespace nightmap
