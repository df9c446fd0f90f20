// SPDX-License-Identifier: Apache-2.0
// Where a round robot can stand and what it costs: the grid inflated by the robot's radius, dearer
// near obstacles.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/io/grid_io.h"

namespace nightmap {

struct RobotOptions {
  double robot_radius_m = 0.25;
  bool unknown_is_obstacle = true;
  double clearance_m = 0.75;      // obstacles farther away cost nothing
  double clearance_weight = 2.0;  // extra cost of a metre at the robot's radius from an obstacle
};

// Cells are those of the grid. A cell is free when the nearest obstacle cell is at least the
// robot's radius away, centre to centre.
struct CostMap {
  static constexpr int kUnitCost = 1024;

  int width = 0;
  int height = 0;
  double resolution_m = 0;
  std::vector<std::int32_t> squared_distances;  // cells^2, to the nearest obstacle cell
  std::vector<std::uint16_t> costs;             // 0: not free; else cost of a metre * kUnitCost

  std::size_t Size() const { return costs.size(); }
  std::size_t Index(const Eigen::Vector2i& cell) const {
    return static_cast<std::size_t>(cell.y()) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(cell.x());
  }
  Eigen::Vector2i Cell(std::size_t index) const {
    const auto columns = static_cast<std::size_t>(width);
    return {static_cast<int>(index % columns), static_cast<int>(index / columns)};
  }
  bool Contains(const Eigen::Vector2i& cell) const {
    return cell.x() >= 0 && cell.y() >= 0 && cell.x() < width && cell.y() < height;
  }
  bool IsFree(const Eigen::Vector2i& cell) const {
    return Contains(cell) && costs[Index(cell)] > 0;
  }
  double Clearance_m(const Eigen::Vector2i& cell) const;
};

// Unknown cells, and everything outside of the grid, are obstacles when the options say so.
CostMap MakeCostMap(const OccupancyGrid& grid, const RobotOptions& options, int num_threads);

// Which free cells reach each other. With diagonal steps that cut no corner these are the
// 4-connected components. Labels count from 1 in order of the first cell; 0 where not free.
std::vector<std::int32_t> LabelReachable(const CostMap& map);

}  // namespace nightmap
