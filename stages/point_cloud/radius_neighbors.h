// SPDX-License-Identifier: Apache-2.0
// Neighbours within a radius, for points of which no two share a voxel.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace nightmap {

struct Neighbor {
  std::size_t index = 0;
  double squared_distance_m2 = 0;
};

// Calls body(i, neighbors) for each point, itself among its neighbours, which come by voxel: by x,
// then y, then z. So what is summed over them does not depend on what else is in the cloud, to the
// last bit, as it would in the order a kd-tree finds them. `voxels` are the points' packed keys, in
// increasing order. `body` runs on several threads; `neighbors` is good until it returns.
void ForEachNeighborhood(
    const std::vector<std::uint64_t>& voxels,
    const std::vector<Eigen::Vector3d>& points,
    double voxel_size_m,
    double radius_m,
    int num_threads,
    const std::function<void(std::size_t, const std::vector<Neighbor>&)>& body);

}  // namespace nightmap
