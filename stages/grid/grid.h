// SPDX-License-Identifier: Apache-2.0
// Projects the octree to a 2-D occupancy grid for planning: a cell is occupied when something a
// robot would hit stands in its column, free when the floor or free space is seen there.
#pragma once

#include <cstddef>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/io/grid_io.h"
#include "pipeline/io/octree_io.h"

namespace nightmap {

// Heights are z in the map frame (floor at 0) and are compared with the centres of voxels, so that
// the floor's noise does not become an obstacle.
struct GridOptions {
  double obstacle_min_height_m = 0.10;
  double obstacle_max_height_m = 1.50;
  int min_occupied_voxels = 1;
  double max_unseen_m = 0.10;
  int speck_min_neighbors = 1;
  int speck_max_voxels = 2;
  double margin_m = 0.25;

  void Register(OptionList& list);
};

struct GridResult {
  OccupancyGrid grid;
  std::size_t num_free_cells = 0;
  std::size_t num_occupied_cells = 0;
  std::size_t num_unknown_cells = 0;
  std::size_t num_floor_cells = 0;  // columns where the floor itself was seen
  std::size_t num_removed_specks = 0;
};

// One cell a column of smallest voxels, edges aligned with the tree's. Below the band lies floor,
// above it ceiling; neither is ever an obstacle. Free space counts from the floor's height up to
// the top of the band. A column with an unseen part between free ones is unknown: that is the mark
// of a table top seen at too flat an angle to be measured, with floor seen below and a wall above.
// Deterministic. Throws UsageError when no voxel centre fits the band, DataError when the tree
// holds nothing between the floor and the top of the band.
GridResult RunGrid(const GridOptions& options, const OccupancyTree& tree, Progress& progress);

}  // namespace nightmap
