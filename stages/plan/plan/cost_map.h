// SPDX-License-Identifier: Apache-2.0
// Cells where a robot can stand, and their cost: the grid inflated by the circle around the robot's
// footprint, with a higher cost near obstacles.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/base/options.h"
#include "pipeline/base/uninitialized_vector.h"
#include "pipeline/io/grid_io.h"
#include "pipeline/plan/obstacle_distances.h"

namespace nightmap {

struct CostOptions {
  OPTION(std::string, unknown, "forbidden", {"forbidden", "allowed", "costed"},
         "how unseen space counts: as an obstacle, as free, or as free at unknown_weight");
  OPTION(double, unknown_weight, 5, {0.0, 10.0},
         "extra cost per metre in unknown space when it is costed");
  OPTION(double, max_hole_m, 0.1, {0.0, 1.0},
         "unseen holes up to this wide, with seen floor all around, count as free; 0: none");
  OPTION(double, clearance_m, 0.75, {0.0, 10.0}, "obstacles farther away than this add no cost");
  OPTION(double, clearance_weight, 2, {0.0, 30.0},
         "extra cost per metre at the robot's radius from an obstacle; 0: shortest path");
  OPTION(double, margin_m, 0.05, {0.0, 1.0},
         "room beside the robot without which a path is taken only where no other way is much "
         "shorter; narrow places are reported");
  OPTION(double, margin_weight, 20, {0.0, 20.0},
         "extra cost per metre with less room than margin_m: length of a detour to avoid it");
  REGISTER_OPTIONS();
};

// Cells are those of the grid inside a rim of cells that are not free, so that a search need not
// check for the border. A cell is free when a circle of the robot's radius touches no obstacle cell
// wherever in the cell its centre is; that is, the squares of the two cells are at least the radius
// apart.
struct CostMap {
  static constexpr int kUnitCost = 1024;

  int width = 0;
  int height = 0;
  double resolution_m = 0;
  double robot_radius_m = 0;
  ObstacleDistances distances;
  UninitializedVector<std::uint16_t>
      costs;              // with the rim. 0: not free; else cost per metre * kUnitCost
  int margin_cost = 0;    // part of the cost of cells with less room than the margin
  int roomy_squared = 0;  // squared distance in cells from which on there is that room

  int Stride() const { return width + 2; }  // step in `costs` from a cell to the one above it
  std::size_t Size() const { return costs.size(); }
  // Index of a cell in `costs`; cells of the rim have one too.
  std::size_t Index(const Eigen::Vector2i& cell) const {
    return static_cast<std::size_t>(cell.y() + 1) * static_cast<std::size_t>(Stride()) +
           static_cast<std::size_t>(cell.x() + 1);
  }
  Eigen::Vector2i Cell(std::size_t index) const {
    const auto stride = static_cast<std::size_t>(Stride());
    return {static_cast<int>(index % stride) - 1, static_cast<int>(index / stride) - 1};
  }
  bool Contains(const Eigen::Vector2i& cell) const {
    return cell.x() >= 0 && cell.y() >= 0 && cell.x() < width && cell.y() < height;
  }
  bool IsFree(const Eigen::Vector2i& cell) const {
    return Contains(cell) && costs[Index(cell)] > 0;
  }
  // Whether a robot in the cell has the margin's room.
  bool IsRoomy(const Eigen::Vector2i& cell) const {
    return distances.Squared(cell, roomy_squared) >= roomy_squared;
  }
  // Any point of the cell is at least this far from any obstacle.
  double Clearance_m(const Eigen::Vector2i& cell) const {
    return resolution_m * std::sqrt(static_cast<double>(distances.Squared(cell)));
  }
};

CostMap MakeCostMap(const OccupancyGrid& grid,
                    const CostOptions& options,
                    double robot_radius_m,
                    int num_threads);

// Labels the free cells that reach each other. With diagonal steps that cut no corner these are the
// 4-connected components. Labels, in order of `costs`, count from 1 in order of their first cell; 0
// in cells that are not free.
std::vector<std::int32_t> LabelReachable(const CostMap& map);

}  // namespace nightmap
