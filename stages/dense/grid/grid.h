// SPDX-License-Identifier: Apache-2.0
// Projects the octree to 2-D occupancy grids for planning, one per floor. A cell is occupied when
// something that a robot would hit stands above its ground or when the ground drops away. It is
// free when the ground, or free space above it, was seen.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/progress.h"
#include "pipeline/dense/octree_leaves.h"
#include "pipeline/io/grid_io.h"

namespace nightmap {

// Heights are compared with voxel centres, so that noise of the floor is no obstacle.
struct GridOptions {
  OPTION(double, robot_height_m, 1.5, {0.05, 10.0},
         "objects that hang higher above the ground do not block the robot");
  OPTION(double, max_step_height_m, 0.10, {0.0, 2.0},
         "the robot drives over sills, kerbs and edges up to this height");
  OPTION(double, min_ramp_area_m2, 0.5, {0.0, 1000},
         "smaller patches that rise or fall from the floor by steps are no ramps");
  OPTION(int, min_occupied_voxels, 1, {1, 100},
         "occupied voxels between step and robot height that make a cell occupied");
  OPTION(double, max_unseen_m, 0.10, {0, 10},
         "a cell with more unseen height between free voxels is unknown, not free");
  OPTION(double, max_hidden_m, 0.5, {0, 10},
         "a cell with more unseen height above a step over unseen ground is unknown, not free");
  OPTION(int, speck_min_neighbors, 1, {0, 8},
         "a cell with fewer occupied neighbours (of 8) is a speck and is removed; 0: keeps all");
  OPTION(double, margin_m, 0.25, {0.0, 10.0}, "width of the unknown border around the seen area");
  REGISTER_OPTIONS();
};

struct FloorGrid {
  double height_m = 0;  // z of the floor in the map frame
  OccupancyGrid grid;
  std::size_t num_free_cells = 0;
  std::size_t num_occupied_cells = 0;
  std::size_t num_unknown_cells = 0;
  std::size_t num_ground_cells = 0;  // cells whose ground itself was seen
  std::size_t num_ramp_cells = 0;  // cells whose ground is more than a step off the floor's height
  std::size_t num_drop_cells = 0;  // occupied because the ground ends
  std::size_t num_unvisited_cells = 0;
  std::size_t num_removed_specks = 0;
};

struct GridResult {
  std::vector<FloorGrid> floors;   // ascending by height
  std::size_t main_floor_idx = 0;  // the floor at z = 0
  double below_lowest_share = 0;   // share of occupied voxels 0.3 m or more below every floor
};

// One cell per column of smallest voxels; edges are aligned with the tree's. The robot drives over
// anything up to max_step_height_m above a cell's ground (FindGround) and passes under anything
// that begins at robot_height_m. Anything between is an obstacle. Free space counts from the ground
// up to the robot's height.
//
// A column is unknown if an unseen part lies between free ones: a table top seen at too flat an
// angle to be measured leaves this pattern, with floor seen below it and a wall above. A column is
// also unknown if neither the ground nor max_hidden_m above a step was seen, because a counter may
// stand there whose top the camera did not measure; a camera carried through it disproves that. A
// column without ground is a drop if its free space leads more than a step below the ground and
// there ends at something seen, or goes on for 0.3 m; it is occupied beside free cells, else
// unknown. Free cells become unknown if they are not connected to a cell under or nearest to a
// camera on that floor, because they were seen through a window or over a wall (not checked if
// `cameras_in_map` is empty). A pane of glass that reaches the ground leaves no trace in an octree.
//
// Deterministic at any number of threads. Throws UsageError when no voxel centre fits between step
// and robot height, DataError when there is no leaf or the main floor has no free and no occupied
// cell; other floors without such cells are left out.
GridResult RunGrid(const GridOptions& options,
                   const LeafSource& leaves,
                   const std::vector<Eigen::Vector3d>& cameras_in_map,
                   Progress& progress,
                   int num_threads);

}  // namespace nightmap
