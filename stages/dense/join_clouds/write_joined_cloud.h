// SPDX-License-Identifier: Apache-2.0
// The files of the joined cloud.
#pragma once

#include "pipeline/program/stage_context.h"
#include "stages/dense/join_clouds/join_clouds.h"

namespace nightmap {

// Reads the inputs tile, tile_cloud and tile_report of the same tiles. Writes the output cloud and,
// if asked for, cloud.pcd next to it. Removes files of other tiles from the folder of the output.
// Voxel size, stride and range are those of the config in the tiles' reports. Throws DataError when
// the tiles were made with different configs, when nothing was measured in any tile, or when more
// than max_failed_ratio of the keyframes could not be read.
void WriteJoinedCloud(const JoinCloudsOptions& options, StageContext& context);

}  // namespace nightmap
