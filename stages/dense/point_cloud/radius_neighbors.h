// SPDX-License-Identifier: Apache-2.0
// Neighbours within a radius, for points in distinct voxels.
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

// Calls body(i, neighbors) for each point, which is among its own neighbours. Neighbours come in
// order of their voxels: by x, then y, then z. So a sum over them does not depend, to the last bit,
// on the rest of the cloud; in the order of a kd-tree it would. `voxels` are the points' packed
// keys, ascending. `body` runs on several threads; `neighbors` is valid until it returns.
void ForEachNeighborhood(
    const std::vector<std::uint64_t>& voxels,
    const std::vector<Eigen::Vector3d>& points,
    double voxel_size_m,
    double radius_m,
    int num_threads,
    const std::function<void(std::size_t, const std::vector<Neighbor>&)>& body);

}  // namespace nightmap
