// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/cloud_order.h"

#include <tuple>

#include "pipeline/geometry/voxel_key.h"

namespace nightmap {

bool ByVoxel(const CloudPoint& a, const CloudPoint& b, double voxel_size_m) {
  const auto key = [voxel_size_m](const CloudPoint& point) {
    const Eigen::Vector3f& p = point.position_in_map;
    const VoxelKey voxel = VoxelOf(p.cast<double>(), voxel_size_m);
    return std::tuple(PackVoxel(voxel), p.x(), p.y(), p.z());
  };
  return key(a) < key(b);
}

}  // namespace nightmap
