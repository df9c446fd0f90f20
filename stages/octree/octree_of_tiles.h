// SPDX-License-Identifier: Apache-2.0
// The octree tile by tile.
#pragma once

#include <filesystem>
#include <vector>

#include "pipeline/geometry/rectangle.h"
#include "pipeline/program/stage_main.h"
#include "stages/octree/octree.h"

namespace nightmap {

// The voxels whose centre lies in the rectangle, at any height an octree reaches. Boxes of the
// tiles of a site share no voxel and leave none out.
VoxelBox VoxelsOf(const Rectangle& rectangle, double resolution_m);

// The points of the clouds that can support the end of a ray that goes through the tile.
std::vector<CloudPoint> ReadCloudAround(const std::vector<std::filesystem::path>& clouds,
                                        const Rectangle& tile,
                                        const OctreeOptions& options);

// What the octree of all keyframes and the whole cloud has in the tile that `source` is of, given
// the clouds of the tile and its neighbours (null: not asked). It may be empty. Throws UsageError
// when a tile is too small, or overlaps too little, for neighbours to tell all about its border.
OctreeResult RunOctreeTile(const OctreeOptions& options,
                           const KeyframeSource& source,
                           const std::vector<CloudPoint>* cloud,
                           Progress& progress,
                           int num_threads);

// From the inputs tile, cameras, data and cloud to the output tile_ot.
void MapOctreeTile(const OctreeOptions& options, StageContext& context);

}  // namespace nightmap
