// SPDX-License-Identifier: Apache-2.0
// join_clouds: one cloud of the building from the clouds of its tiles.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/io/ply_io.h"
#include "pipeline/program/stage_context.h"

namespace nightmap {

struct JoinCloudsOptions {
  bool export_pcd = false;
  double max_failed_ratio = 0.05;

  void Register(OptionList& list);
};

// Calls add(point) for the points of all clouds in the order of ByVoxel, in which each of them is:
// the order of a cloud made as one tile. Holds one point of each cloud in memory.
void MergeClouds(const std::vector<std::filesystem::path>& clouds,
                 double voxel_size_m,
                 const std::function<void(const CloudPoint&)>& add);

// From the inputs tile, tile_cloud and tile_report, of the same tiles, to the output cloud and,
// when asked for, cloud.pcd beside it. Removes from the folder of the output what is of other
// tiles. Voxels, stride and range are those of the config in the tiles' reports. Throws DataError
// when the tiles were made with different configs, when nothing was measured in any tile, or when
// more than max_failed_ratio of the keyframes could not be read.
void RunJoinClouds(const JoinCloudsOptions& options, StageContext& context);

}  // namespace nightmap
