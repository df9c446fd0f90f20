// SPDX-License-Identifier: Apache-2.0
// join_clouds: joins the clouds of a building's tiles into one cloud.
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

// Calls add(point) for the points of all clouds in the order of ByVoxel. Each cloud must be in that
// order already; the result has the order of a cloud made as one tile. Holds one point per cloud in
// memory.
void MergeClouds(const std::vector<std::filesystem::path>& clouds,
                 double voxel_size_m,
                 const std::function<void(const CloudPoint&)>& add);

// Reads the inputs tile, tile_cloud and tile_report of the same tiles. Writes the output cloud and,
// if asked for, cloud.pcd next to it. Removes files of other tiles from the folder of the output.
// Voxel size, stride and range are those of the config in the tiles' reports. Throws DataError when
// the tiles were made with different configs, when nothing was measured in any tile, or when more
// than max_failed_ratio of the keyframes could not be read.
void RunJoinClouds(const JoinCloudsOptions& options, StageContext& context);

}  // namespace nightmap
