// SPDX-License-Identifier: Apache-2.0
#include "pipeline/dense/octree_io.h"

#include "pipeline/dense/octree_reader.h"

namespace nightmap {

double OctreeReach_m(double resolution_m) { return resolution_m * (1 << (kOctreeDepth - 1)); }

OccupancyTree ReadOctree(const std::filesystem::path& path) {
  OctreeReader reader(path);
  OccupancyTree tree{reader.Resolution_m(), {}};
  while (const auto leaf = reader.Next()) {
    tree.leaves.push_back(ToVoxel(*leaf, tree.resolution_m));
  }
  return tree;
}

}  // namespace nightmap
