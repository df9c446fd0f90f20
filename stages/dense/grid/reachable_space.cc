// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/grid/reachable_space.h"

#include <array>
#include <cmath>
#include <optional>

namespace nightmap {
namespace {

constexpr double kNearby_m = 1.0;

// The free cell nearest to a cell; ties: the first.
std::optional<Eigen::Vector2i> NearestFree(const OccupancyGrid& grid, const Eigen::Vector2i& cell) {
  const int reach = static_cast<int>(std::lround(kNearby_m / grid.resolution_m));
  std::optional<Eigen::Vector2i> nearest;
  int best = reach * reach + 1;
  for (int dy = -reach; dy <= reach; ++dy) {
    for (int dx = -reach; dx <= reach; ++dx) {
      const Eigen::Vector2i near = cell + Eigen::Vector2i(dx, dy);
      const int squared = dx * dx + dy * dy;
      if (squared >= best || !grid.Contains(near) || grid.At(near) != kFreeCell) continue;
      best = squared;
      nearest = near;
    }
  }
  return nearest;
}

// Cells of the grid under a camera that is at most `max_camera_height_m` above the ground.
std::vector<Eigen::Vector2i> CellsUnderCameras(const std::vector<Eigen::Vector3d>& cameras_in_map,
                                               const std::vector<double>& ground_m,
                                               double max_camera_height_m,
                                               const OccupancyGrid& grid) {
  std::vector<Eigen::Vector2i> cells;
  for (const Eigen::Vector3d& camera : cameras_in_map) {
    const Eigen::Vector2i cell = grid.CellOf(camera.head<2>());
    if (!grid.Contains(cell)) continue;
    const double height_m = camera.z() - ground_m[grid.Index(cell.x(), cell.y())];
    if (height_m >= 0 && height_m <= max_camera_height_m) cells.push_back(cell);
  }
  return cells;
}

}  // namespace

std::vector<bool> CellsAroundCameras(const std::vector<Eigen::Vector3d>& cameras_in_map,
                                     const std::vector<double>& ground_m,
                                     double max_camera_height_m,
                                     double reach_m,
                                     const OccupancyGrid& grid) {
  std::vector<bool> is_around(grid.cells.size(), false);
  const double reach = reach_m / grid.resolution_m;
  const int last = static_cast<int>(reach);
  for (const Eigen::Vector2i& cell :
       CellsUnderCameras(cameras_in_map, ground_m, max_camera_height_m, grid)) {
    for (int dy = -last; dy <= last; ++dy) {
      for (int dx = -last; dx <= last; ++dx) {
        const Eigen::Vector2i near = cell + Eigen::Vector2i(dx, dy);
        if (dx * dx + dy * dy > reach * reach || !grid.Contains(near)) continue;
        is_around[grid.Index(near.x(), near.y())] = true;
      }
    }
  }
  return is_around;
}

std::size_t RemoveUnvisited(const std::vector<Eigen::Vector3d>& cameras_in_map,
                            const std::vector<double>& ground_m,
                            double max_camera_height_m,
                            OccupancyGrid& grid) {
  std::vector<Eigen::Vector2i> open;
  for (const Eigen::Vector2i& cell :
       CellsUnderCameras(cameras_in_map, ground_m, max_camera_height_m, grid)) {
    const bool is_free = grid.At(cell) == kFreeCell;
    if (const auto free = is_free ? cell : NearestFree(grid, cell)) open.push_back(*free);
  }
  if (open.empty()) return 0;
  constexpr std::array<std::array<int, 2>, 4> kSides = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
  std::vector<bool> is_visited(grid.cells.size(), false);
  while (!open.empty()) {
    const Eigen::Vector2i cell = open.back();
    open.pop_back();
    if (is_visited[grid.Index(cell.x(), cell.y())]) continue;
    is_visited[grid.Index(cell.x(), cell.y())] = true;
    for (const auto& [dx, dy] : kSides) {
      const Eigen::Vector2i next = cell + Eigen::Vector2i(dx, dy);
      if (grid.Contains(next) && grid.At(next) == kFreeCell) open.push_back(next);
    }
  }
  std::size_t num_removed = 0;
  for (std::size_t i = 0; i < grid.cells.size(); ++i) {
    if (grid.cells[i] != kFreeCell || is_visited[i]) continue;
    grid.cells[i] = kUnknownCell;
    ++num_removed;
  }
  return num_removed;
}

}  // namespace nightmap
