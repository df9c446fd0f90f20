// SPDX-License-Identifier: Apache-2.0
// Octrees put together voxel by voxel, and the state of the cells that grids of them have.
#pragma once

#include <array>
#include <map>

#include "stages/dense/grid/grid.h"

namespace nightmap {

inline constexpr double kResolution_m = 0.05;

// Smallest voxels by key; centre (k + 0.5) * resolution.
class VoxelRoom {
 public:
  VoxelRoom& Fill(Eigen::Vector3i low, Eigen::Vector3i high, bool occupied) {
    for (int x = low.x(); x <= high.x(); ++x) {
      for (int y = low.y(); y <= high.y(); ++y) {
        for (int z = low.z(); z <= high.z(); ++z) voxels_[{x, y, z}] = occupied;
      }
    }
    return *this;
  }
  VoxelRoom& Erase(Eigen::Vector3i low, Eigen::Vector3i high) {
    std::erase_if(voxels_, [&](const auto& voxel) {
      const Eigen::Vector3i key(voxel.first[0], voxel.first[1], voxel.first[2]);
      return (key.array() >= low.array()).all() && (key.array() <= high.array()).all();
    });
    return *this;
  }
  OccupancyTree Tree() const {
    OccupancyTree tree{kResolution_m, {}};
    for (const auto& [key, occupied] : voxels_) {
      const Eigen::Vector3d centre(key[0] + 0.5, key[1] + 0.5, key[2] + 0.5);
      tree.leaves.push_back(Leaf(kResolution_m * centre, kResolution_m, occupied));
    }
    return tree;
  }
  static OccupancyVoxel Leaf(const Eigen::Vector3d& centre, double size_m, bool occupied) {
    return {centre, size_m, occupied ? 2.0f : -1.0f, {255, 255, 255}};
  }

 private:
  std::map<std::array<int, 3>, bool> voxels_;
};

// 20 x 20 cells: floor at z = -0.05..0.05 m, ceiling at 2.5 m, free between.
inline VoxelRoom EmptyRoom() {
  VoxelRoom room;
  room.Fill({0, 0, 0}, {19, 19, 48}, false);
  room.Fill({0, 0, -1}, {19, 19, 0}, true);
  room.Fill({0, 0, 49}, {19, 19, 50}, true);
  return room;
}

inline GridResult ProjectFloors(const OccupancyTree& tree,
                                const GridOptions& options = {},
                                const std::vector<Eigen::Vector3d>& cameras_in_map = {},
                                int num_threads = 1) {
  Progress progress("grid", false);
  return RunGrid(options, LeavesOfTree(tree), cameras_in_map, progress, num_threads);
}

// The grid of the floor at z = 0.
inline FloorGrid Project(const OccupancyTree& tree,
                         const GridOptions& options = {},
                         const std::vector<Eigen::Vector3d>& cameras_in_map = {}) {
  const GridResult result = ProjectFloors(tree, options, cameras_in_map);
  return result.floors[result.main_floor_idx];
}

// The state of the cell of these voxels; unknown outside of the grid.
inline int CellAt(const FloorGrid& floor, int x, int y) {
  const Eigen::Vector2d point(kResolution_m * (x + 0.5), kResolution_m * (y + 0.5));
  const Eigen::Vector2i cell = floor.grid.CellOf(point);
  return floor.grid.Contains(cell) ? floor.grid.At(cell) : std::uint8_t{kUnknownCell};
}

}  // namespace nightmap
