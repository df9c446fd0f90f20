// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/join_octrees/join_octrees.h"

#include "pipeline/base/error.h"
#include "pipeline/dense/octree_io.h"
#include "pipeline/dense/tile_results.h"

namespace nightmap {
namespace {

void CheckOccupied(const VoxelCounts& counts, const TileResults& results) {
  if (counts.num_occupied > 0) return;
  throw DataError(
      "{}: nothing is occupied after this and all {} keyframes ({} unreadable); check "
      "depth_units_per_m of the site's cameras, raise octree.max_range_m, lower "
      "octree.occupancy_threshold or min_keyframes, or set octree.require_cloud_support = false",
      results.first_depth_path,
      results.num_keyframes,
      results.skipped.Count());
}

}  // namespace

void JoinOctreeFiles(const JoinOctreesOptions& options, StageContext& context) {
  const TileResults results = CheckTileParts(context, "tile_ot", options.max_failed_ratio);
  const VoxelCounts counts =
      MergeOctrees(context.Inputs("tile_ot"), context.Output("ot"), context.Output("bt"));
  CheckOccupied(counts, results);
  RemoveOtherTiles(std::filesystem::absolute(context.FinalPath("ot")).parent_path(),
                   context.Inputs("tile"));
  context.Report()["num_tiles"] = context.Inputs("tile").size();
  context.Report()["num_keyframes"] = results.num_keyframes;
  context.Report()["num_occupied_voxels"] = counts.num_occupied;
  context.Report()["num_free_voxels"] = counts.num_free;
}

}  // namespace nightmap
