// SPDX-License-Identifier: Apache-2.0
// The clouds of all tiles to one.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "pipeline/base/stage_main.h"
#include "stages/point_cloud/point_cloud.h"

namespace nightmap {

// Calls add(point) for the points of all clouds in the order of ByVoxel, in which each of them is:
// the order of a cloud made as one tile. Holds one point of each cloud in memory.
void JoinClouds(const std::vector<std::filesystem::path>& clouds,
                double voxel_size_m,
                const std::function<void(const CloudPoint&)>& add);

// From the inputs tile, tile_cloud and tile_report, of the same tiles, to the output cloud and,
// when asked for, cloud.pcd beside it. Throws DataError when nothing was measured in any tile, or
// more than max_failed_ratio of the keyframes could not be read.
void JoinTiles(const PointCloudOptions& options, StageContext& context);

}  // namespace nightmap
