// SPDX-License-Identifier: Apache-2.0
// Makes the octree tile by tile.
#pragma once

#include <filesystem>
#include <vector>

#include "pipeline/geometry/rectangle.h"
#include "stages/dense/octree/octree.h"

namespace nightmap {

// The voxels whose centre lies in the rectangle, at any height that an octree reaches. Boxes of a
// site's tiles are disjoint and leave no voxel out.
VoxelBox VoxelsOf(const Rectangle& rectangle, double resolution_m);

// The points of the clouds that can support the end of a ray through the tile.
std::vector<CloudPoint> ReadCloudAround(const std::vector<std::filesystem::path>& clouds,
                                        const Rectangle& tile,
                                        const OctreeOptions& options);

// The part of the whole octree in the tile of `source`, given the clouds of the tile and its
// neighbours (null: not checked). It may be empty. Throws UsageError when a tile is so small, or
// overlaps so little, that its neighbours do not hold all data about its border.
OctreeResult RunOctreeTile(const OctreeOptions& options,
                           const KeyframeSource& source,
                           const std::vector<CloudPoint>* cloud,
                           Progress& progress,
                           int num_threads);

}  // namespace nightmap
