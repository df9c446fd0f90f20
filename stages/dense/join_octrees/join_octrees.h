// SPDX-License-Identifier: Apache-2.0
// join_octrees: joins the octrees of a building's tiles into one octree.
#pragma once

#include "pipeline/base/options.h"
#include "pipeline/program/stage_context.h"

namespace nightmap {

struct JoinOctreesOptions {
  OPTION(double, max_failed_ratio, 0.05, {0.0, 1.0},
         "share of unreadable keyframes above which the stage fails");
  REGISTER_OPTIONS();
};

// Reads the inputs tile, tile_ot and tile_report of the same tiles. Writes the outputs ot and bt.
// Removes files of other tiles from the folder of ot. The stride of the keyframes is that of the
// config in the tiles' reports. Throws DataError when the tiles were made with different configs,
// when nothing is occupied in any tile, or when more than max_failed_ratio of the keyframes could
// not be read. The join itself is MergeOctrees, which streams from file to file.
void JoinOctreeFiles(const JoinOctreesOptions& options, StageContext& context);

}  // namespace nightmap
