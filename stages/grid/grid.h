// SPDX-License-Identifier: Apache-2.0
// Projects the octree to 2-D occupancy grids for planning, one a floor: a cell is occupied when
// something that a robot would hit stands over its ground or the ground drops away, free when the
// ground or free space above it is seen.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/io/grid_io.h"
#include "pipeline/io/octree_leaves.h"

namespace nightmap {

// Heights are compared with the centres of voxels, so that the floor's noise is no obstacle.
struct GridOptions {
  double robot_height_m = 1.5;
  double max_step_height_m = 0.10;
  double min_floor_area_m2 = 3.0;
  double min_floor_distance_m = 2.0;
  double min_ramp_area_m2 = 0.5;
  int min_occupied_voxels = 1;
  double max_unseen_m = 0.10;
  double max_hidden_m = 0.5;
  int speck_min_neighbors = 1;
  int speck_max_voxels = 2;
  double margin_m = 0.25;

  void Register(OptionList& list);
};

struct FloorGrid {
  double height_m = 0;  // z of the floor in the map frame
  OccupancyGrid grid;
  std::size_t num_free_cells = 0;
  std::size_t num_occupied_cells = 0;
  std::size_t num_unknown_cells = 0;
  std::size_t num_ground_cells = 0;  // where the ground itself was seen
  std::size_t num_ramp_cells = 0;    // whose ground is more than a step off the floor's height
  std::size_t num_drop_cells = 0;    // occupied because the ground ends
  std::size_t num_unvisited_cells = 0;
  std::size_t num_removed_specks = 0;
};

struct GridResult {
  std::vector<FloorGrid> floors;   // rising
  std::size_t main_floor_idx = 0;  // the one at z = 0
  double below_lowest_share = 0;   // of the occupied voxels that lie 0.3 m below every floor
};

// One cell a column of smallest voxels, edges aligned with the tree's. What lies up to
// max_step_height_m above a cell's ground (FindGround) the robot drives over, what begins at
// robot_height_m it passes under; anything between is an obstacle. Free space counts from the
// ground up to the robot's height. A column with an unseen part between free ones is unknown: that
// is the mark of a table top seen at too flat an angle to be measured, with floor seen below and a
// wall above. So is one where neither the ground nor max_hidden_m above a step was seen: a counter
// may be there whose top the camera did not measure, unless a camera was carried there. A column
// without ground whose free space leads down more than a step below it, to something seen there or
// 0.3 m on, is a drop: occupied beside free cells, else unknown. Free cells that are not joined to
// one under or nearest to a camera on that floor (`cameras_in_map`; empty: not asked) are unknown:
// what is seen through a window, or over a wall. A pane of glass that reaches the ground leaves no
// trace in an octree. Deterministic, at any number of threads. Throws UsageError when no voxel
// centre fits between step and robot height, DataError when there is no leaf or the main floor has
// no free and no occupied cell; other floors without one are left out.
GridResult RunGrid(const GridOptions& options,
                   const LeafSource& leaves,
                   const std::vector<Eigen::Vector3d>& cameras_in_map,
                   Progress& progress,
                   int num_threads);

}  // namespace nightmap
