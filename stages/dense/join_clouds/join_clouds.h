// SPDX-License-Identifier: Apache-2.0
// join_clouds: joins the clouds of a building's tiles into one cloud.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/dense/ply_io.h"

namespace nightmap {

struct JoinCloudsOptions {
  OPTION(bool, export_pcd, false, "also writes cloud.pcd, for PCL");
  OPTION(double, max_failed_ratio, 0.05, {0.0, 1.0},
         "share of unreadable keyframes above which the stage fails");
  REGISTER_OPTIONS();
};

// Returns the points of one cloud in the order of ByVoxel, then none.
using PointSource = std::function<std::optional<CloudPoint>()>;

// Calls add(point) for the points of all clouds in the order of ByVoxel, which is the order of a
// cloud made as one tile. Holds one point per cloud in memory.
void RunJoinClouds(const std::vector<PointSource>& clouds,
                   double voxel_size_m,
                   const std::function<void(const CloudPoint&)>& add);

}  // namespace nightmap
