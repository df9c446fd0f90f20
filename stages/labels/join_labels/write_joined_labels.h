// SPDX-License-Identifier: Apache-2.0
// The files of join_labels.
#pragma once

#include "pipeline/program/stage_context.h"
#include "stages/labels/join_labels/join_labels.h"

namespace nightmap {

// Reads the inputs tile, tile_labels and tile_report of the same tiles, the octree and the cloud.
// Writes ot, legend and cloud, and voxels.h5 beside ot, and removes files of other tiles from their
// folder. Throws DataError when the tiles were made with different configs, or when more than
// max_failed_ratio of the keyframes could not be read, UsageError on a bad palette.
void WriteJoinedLabels(const JoinLabelsOptions& options, StageContext& context);

}  // namespace nightmap
